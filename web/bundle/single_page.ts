import { dirname } from "node:path";
import { singleModule } from "./single_module.ts";

const web = dirname(import.meta.dirname);

/** The policy of the page. It allows no requests, because the page contains everything that it needs. */
const policy =
  "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval'; worker-src blob: data:; " +
  "style-src 'unsafe-inline'; img-src data: blob:; font-src data:; connect-src data: blob:";

/**
 * The HTML of a page that needs no other file, without its store. Workers and WebAssembly are in it as
 * data; it works from file://.
 */
export async function singlePage(): Promise<string> {
  const { code, css } = await singleModule(`${web}/page/single_page.ts`);
  const script = code.replaceAll("</script", "<\\/script").replaceAll("<!--", "<\\!--");
  return `<!doctype html>
<html lang="en" class="wa-light wa-brand-cyan">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1, viewport-fit=cover">
<meta name="color-scheme" content="light dark">
<meta http-equiv="Content-Security-Policy" content="${policy}">
<title>Isosplat</title>
<style>${css}
.brand { pointer-events: none; }</style>
</head>
<body>
<div id="page"><noscript>Isosplat needs JavaScript, WebAssembly and WebGL 2. <span lang="de">Isosplat braucht JavaScript, WebAssembly und WebGL 2.</span></noscript></div>
<!-- store -->
<script type="module">${script}</script>
</body>
</html>
`;
}
