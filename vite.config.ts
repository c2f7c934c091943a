import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { brotliCompressSync, constants } from "node:zlib";
import { defineConfig, type Plugin } from "vite";
import { bundledPackages } from "./web/bundle/bundled_packages.ts";
import { serviceWorker } from "./web/bundle/service_worker.ts";
import { singleModule } from "./web/bundle/single_module.ts";
import { singlePage } from "./web/bundle/single_page.ts";

const here = (path: string) => fileURLToPath(new URL(path, import.meta.url));

/** Writes F.br beside every F that shrinks by it: a fifth fewer bytes than what gzip would send. */
function compressed(): Plugin {
  return {
    name: "isosplat-compressed",
    apply: "build",
    enforce: "post",
    generateBundle: {
      order: "post",
      handler(_options, bundle) {
        for (const file of Object.values(bundle)) {
          if (!/\.(js|css|wasm|svg|html)$/.test(file.fileName)) continue;
          const source = file.type === "chunk" ? file.code : file.source;
          const bytes = typeof source === "string" ? Buffer.from(source) : source;
          const params = { [constants.BROTLI_PARAM_QUALITY]: 11 };
          const packed = brotliCompressSync(bytes, { params });
          if (packed.length < 0.95 * bytes.length) {
            this.emitFile({ type: "asset", fileName: `${file.fileName}.br`, source: packed });
          }
        }
      },
    },
  };
}

/** What server/routes/page_route.cpp sends, for hosts that send no policy. */
const policy =
  "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self' blob:; " +
  "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; manifest-src 'self'; " +
  "connect-src 'self' http: https: data: blob:; base-uri 'none'; form-action 'none'";

/** The page states its policy itself. */
function statedPolicy(): Plugin {
  return {
    name: "isosplat-stated-policy",
    apply: "build",
    transformIndexHtml: (html, { filename }) =>
      filename.endsWith("index.html")
        ? html.replace(
            '<meta charset="utf-8" />',
            (charset) =>
              `${charset}\n    <meta http-equiv="Content-Security-Policy" content="${policy}" />`,
          )
        : html,
  };
}

/**
 * The renderer is asked for beside the page's own script, not after it has run: one round trip less
 * until the first surface.
 */
function preloadedRenderer(): Plugin {
  return {
    name: "isosplat-preloaded-renderer",
    apply: "build",
    transformIndexHtml: {
      order: "post",
      handler(_html, { bundle }) {
        const find = (pattern: RegExp) =>
          Object.keys(bundle ?? {}).filter((file) => pattern.test(file));
        const link = (attrs: Record<string, string | boolean>) => ({
          tag: "link",
          attrs: { crossorigin: true, ...attrs },
          injectTo: "head" as const,
        });
        return [
          ...find(/isosplat-renderer-[^.]*\.wasm$/).map((file) =>
            link({ rel: "preload", as: "fetch", type: "application/wasm", href: `./${file}` }),
          ),
          ...find(/isosplat-renderer-[^.]*\.js$/).map((file) =>
            link({ rel: "modulepreload", href: `./${file}` }),
          ),
        ];
      },
    },
  };
}

/** The service worker, which has the list of all files that the page needs without a network. */
function offline(): Plugin {
  return {
    name: "isosplat-offline",
    apply: "build",
    enforce: "post",
    generateBundle: {
      order: "post",
      async handler(_options, bundle) {
        const add = (fileName: string, source: string) =>
          this.emitFile({ type: "asset", fileName, source });
        add("manifest.webmanifest", readFileSync(here("web/offline/manifest.json"), "utf8"));
        add("icon.svg", readFileSync(here("web/page/mark.svg"), "utf8"));
        const hash = createHash("sha256");
        // Not single.html, which few visitors save: its bytes are those of all others together.
        const files = ["files.json"]; // from the same sources, made later
        for (const file of Object.values(bundle)) {
          if (/\.br$|^(embed\.html|isosplat-(viewer|anywidget(-single)?)\.js)$/.test(file.fileName))
            continue;
          // Each visitor needs one language: it is kept when it is used (web/offline/page_cache.ts).
          const entry = file.type === "chunk" ? (file.facadeModuleId ?? "") : "";
          if (/\/web\/texts\/|\/webawesome\/dist\/translations\//.test(entry)) continue;
          files.push(file.fileName === "index.html" ? "" : file.fileName);
          hash.update(file.type === "chunk" ? file.code : file.source);
        }
        const version = hash.digest("hex").slice(0, 16);
        add("service-worker.js", await serviceWorker({ version, files }));
      },
    },
  };
}

/** zarrita's own codecs: web/zarr replaces them, so the page does not carry them. */
function withoutNumcodecs(): Plugin {
  return {
    name: "isosplat-without-numcodecs",
    load: (id) => (/\/node_modules\/numcodecs\//.test(id) ? "export default undefined" : null),
  };
}

/** The widget of notebooks in one file, for those that cannot reach the server: the kernel sends it. */
function singleWidget(): Plugin {
  return {
    name: "isosplat-single-widget",
    apply: "build",
    enforce: "post",
    generateBundle: {
      order: "post",
      async handler() {
        const { code } = await singleModule(here("web/element/anywidget.ts"));
        this.emitFile({ type: "asset", fileName: "isosplat-anywidget-single.js", source: code });
      },
    },
  };
}

/** What the page needs to save copies of itself: single.html, and files.json with its files' names. */
function copies(): Plugin {
  return {
    name: "isosplat-copies",
    apply: "build",
    enforce: "post",
    generateBundle: {
      order: "post",
      async handler(_options, bundle) {
        const files = Object.values(bundle)
          .filter(({ fileName }) => !fileName.endsWith(".br"))
          .map((file) => {
            const content = file.type === "chunk" ? file.code : file.source;
            return { name: file.fileName, bytes: Buffer.byteLength(content) };
          });
        const html = await singlePage();
        files.push({ name: "single.html", bytes: Buffer.byteLength(html) });
        this.emitFile({ type: "asset", fileName: "single.html", source: html });
        const list = `${JSON.stringify({ files })}\n`;
        this.emitFile({ type: "asset", fileName: "files.json", source: list });
      },
    },
  };
}

/** The npm packages in the page, for the list of components of a release. */
const listed = () => bundledPackages(here("build/page.packages.json"), ["numcodecs"]);

/**
 * The page. `npm run build:page` writes build/page, which the server hands out; `npm run dev` serves
 * it with hot reload and passes /v1 on to a running server (ISOSPLAT_SERVER, default port 8080).
 */
export default defineConfig({
  root: here("web"),
  // Relative addresses: the page works at any path of any static host.
  base: "./",
  plugins: [
    statedPolicy(),
    preloadedRenderer(),
    offline(),
    copies(),
    singleWidget(),
    compressed(),
    listed(),
  ],
  build: {
    outDir: here("build/page"),
    emptyOutDir: true,
    target: "es2022",
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    rolldownOptions: {
      input: {
        index: here("web/index.html"),
        embed: here("web/embed.html"),
        "isosplat-viewer": here("web/element/index.ts"),
        "isosplat-anywidget": here("web/element/anywidget.ts"),
      },
      // Pages name the element's script, and notebooks the widget's, so their addresses stay the same.
      output: {
        entryFileNames: ({ name }) =>
          /^isosplat-(viewer|anywidget)$/.test(name) ? "[name].js" : "assets/[name]-[hash].js",
        // One request for what all pages need, not one for each small file that two of them share.
        codeSplitting: {
          groups: [
            {
              name: "viewer",
              test: /\/web\/(core|stream|viewer)\/|overlay\/(parts|axis_names)|texts\/(part|numbers|faults|languages|overlay)\.ts/,
            },
            // All that index.html loads at once, with what it imports.
            {
              name: "page",
              test: /\/web\/page\/(volume\/volume_page|address\/open_target)\.ts|\/web\/texts\/language\.ts/,
            },
          ],
        },
      },
      preserveEntrySignatures: "exports-only",
    },
  },
  worker: { format: "es", plugins: () => [withoutNumcodecs(), listed()] },
  server: {
    proxy: { "/v1": process.env.ISOSPLAT_SERVER ?? "http://localhost:8080" },
    fs: { allow: [here(".")] },
  },
});
