import { dirname } from "node:path";
import { build, type Rollup } from "vite";

const web = dirname(import.meta.dirname);

/**
 * A module with all that it imports in one script, which fetches nothing: workers and WebAssembly are in it as
 * data. `entry`: the path of its source. `css`: the style sheets that it imports.
 */
export async function singleModule(entry: string): Promise<{ code: string; css: string }> {
  const built = (await build({
    configFile: false,
    root: web,
    base: "./",
    logLevel: "error",
    build: {
      write: false,
      target: "es2022",
      assetsInlineLimit: 0,
      modulePreload: false,
      rolldownOptions: {
        input: entry,
        output: { format: "es", codeSplitting: false },
        preserveEntrySignatures: "exports-only",
      },
    },
    worker: { format: "es", rolldownOptions: { output: { codeSplitting: false } } },
  })) as Rollup.RollupOutput;
  const chunk = built.output.find((file) => file.type === "chunk" && file.isEntry);
  if (chunk?.type !== "chunk") throw new Error("expected one script, found none");
  let { code } = chunk;
  let css = "";
  const files = built.output.filter((file) => file !== chunk).map(contentOf);
  // Workers fetch nothing: they get compiled modules, and the renderer's module contains the core.
  for (const { name, bytes } of files) {
    if (name.endsWith(".css")) css += bytes.toString();
    const [, module] = name.match(/isosplat-(renderer|mesh).*\.wasm$/) ?? [];
    if (!module) continue;
    const data = `data:application/wasm;base64,${bytes.toString("base64")}`;
    code = `const isosplat_${module}="${data}";${inPlace(code, name, `new URL(isosplat_${module})`)}`;
  }
  for (const { name, bytes } of files) {
    if (!name.endsWith(".js")) continue;
    // A page at a file: URL cannot start module workers. These workers import nothing, so they can be classic ones.
    const worker = bytes
      .toString()
      .replace(anyWasm, 'new URL("data:,")')
      .replaceAll("import.meta.url", "self.location.href");
    const source = JSON.stringify(worker);
    code = inPlace(
      code,
      name,
      `new URL(URL.createObjectURL(new Blob([${source}],{type:"text/javascript"})))`,
    );
  }
  code = code.replace(/\{type:[`"']module[`"']\}/g, "{}");
  return { code, css };
}

function contentOf(file: Rollup.OutputAsset | Rollup.OutputChunk) {
  const bytes = Buffer.from(file.type === "chunk" ? file.code : file.source);
  return { name: file.fileName, bytes };
}

/** Addresses relative to a worker that is a Blob are errors, even if nothing is fetched from them. */
const anyWasm = /new URL\([^()]*?\.wasm["'`]\s*,[^()]*?import\.meta\.url\)/g;

/** The script with an expression in place of each address of a file. */
function inPlace(code: string, fileName: string, expression: string): string {
  const name = fileName.slice(fileName.lastIndexOf("/") + 1).replaceAll(".", "\\.");
  const address = new RegExp(
    `new URL\\([^()]*?${name}["'\`]\\s*,[^()]*?import\\.meta\\.url\\)`,
    "g",
  );
  if (code.search(address) < 0) throw new Error(`expected the address of ${fileName}, found none`);
  return code.replace(address, () => expression);
}
