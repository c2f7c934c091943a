// load_page.mjs URL: loads the page, the files that it names, the list of volumes and a volume from
// a running server. Fails with what was expected.
const base = new URL(process.argv[2]);

async function load(path, type) {
  const response = await fetch(new URL(path, base));
  const found = response.headers.get("content-type") ?? "";
  if (!response.ok || !found.startsWith(type)) {
    throw new Error(`${path}: expected ${type}, found ${response.status} ${found}`);
  }
  return response;
}

const page = await (await load("/", "text/html")).text();
const files = [...page.matchAll(/(?:src|href)="(\.?\/?assets\/[^"]+)"/g)].map((match) => match[1]);
if (files.length === 0) throw new Error("expected the page to name its scripts");
for (const file of files) {
  await load(
    file,
    file.endsWith(".js") ? "text/javascript" : file.endsWith(".css") ? "text/css" : "",
  );
}
const { volumes } = await (await load("/v1/volumes", "application/json")).json();
if (volumes.length !== 1) throw new Error(`expected one volume, found ${volumes.length}`);
console.log(`${files.length} files of the page, volume ${volumes[0].name ?? volumes[0].id}`);
