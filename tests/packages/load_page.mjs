// load_page.mjs URL: loads the page, the files that it names, the list of volumes, a volume and one
// of its chunks from a running server. Errors state what was expected.
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
const volume = await (await load(volumes[0].url, "application/json")).json();
const address = `${volume.urls.chunks}?isovalue=${volume.range.join("..")}&level=0`;
const frames = new DataView(
  await (await load(address, "application/vnd.isosplat.frames")).arrayBuffer(),
);
// The header of the first frame (server/HTTP.md, Frames) names the chunk that follows it. This chunk
// also has a separate address.
const [bytes, , level, x, y, z, band] = Array.from({ length: 7 }, (_, i) =>
  frames.getUint32(4 * i, true),
);
const url = `${volume.urls.chunks}/${level}/${x}.${y}.${z}/${band}`;
const chunk = Buffer.from(await (await load(url, "application/octet-stream")).arrayBuffer());
if (bytes === 0 || !chunk.equals(Buffer.from(frames.buffer, 48, bytes))) {
  throw new Error(`${url}: expected the ${bytes} bytes of its frame, found ${chunk.length}`);
}
console.log(`${files.length} files of the page, volume ${volume.name}, a chunk of ${bytes} bytes`);
