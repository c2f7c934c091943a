/** The bundlers and frameworks with which the npm package is tried, and what each of them needs. */

/** A way to make a page of a project, and to serve it. Commands run in the project. */
export interface Way {
  name: "build" | "dev" | "types";
  commands?: readonly string[];
  /** What serves the page: a folder of the project, or a command that listens at a port. None: no page. */
  serves?: { folder: string } | { command(port: number): string };
}

export interface Fixture {
  name: string;
  /** The folder of projects/ that is copied. */
  project: string;
  /** The tool as the table names it, with its version from `packages`. */
  tool: { title: string; package: string };
  packages: Readonly<Record<string, string>>;
  /** Further fields of the project's package.json. */
  manifest?: object;
  ways: readonly Way[];
  /** The pages that are opened. Default: the first. */
  pages?: readonly string[];
  /** What a user has to write, in Markdown. */
  needs: string;
}

const react19 = { react: "19.3.1", "react-dom": "19.3.1" };
/** For tools that need a newer Node than Isosplat: its program, which is first in the project's PATH. */
const newerNode = { node: "22.23.3" };
const noSetting = "nothing";
const noPrebundling = '`dev`: `optimizeDeps: { exclude: ["isosplat"] }`';

function vite(major: number, version: string, needs: string): Fixture {
  return {
    name: `vite${major}`,
    project: major < 8 ? "vite_excluded" : "vite",
    tool: { title: "Vite", package: "vite" },
    packages: { vite: version },
    ways: [
      { name: "build", commands: ["vite build"], serves: { folder: "dist" } },
      { name: "dev", serves: { command: viteServer } },
    ],
    needs,
  };
}

function viteServer(port: number): string {
  return `vite --host 127.0.0.1 --port ${port} --strictPort`;
}

function react(major: number, packages: Record<string, string>, needs: string): Fixture {
  return {
    name: `react${major}`,
    project: "react",
    tool: { title: "React", package: "react" },
    packages: { vite: "8.3.8", "@vitejs/plugin-react": "6.3.0", ...packages },
    ways: [
      { name: "build", commands: ["vite build"], serves: { folder: "dist" } },
      { name: "dev", serves: { command: viteServer } },
    ],
    needs,
  };
}

function next(name: string, title: string, version: string, bundler = ""): Fixture {
  return {
    name,
    project: "next",
    tool: { title, package: "next" },
    packages: { next: version, ...react19 },
    ways: [
      {
        name: "build",
        commands: [`next build${bundler}`],
        serves: { command: (port) => `next start --hostname 127.0.0.1 --port ${port}` },
      },
      {
        name: "dev",
        serves: { command: (port) => `next dev${bundler} --hostname 127.0.0.1 --port ${port}` },
      },
    ],
    pages: ["", "no-ssr"],
    needs: '`"use client"` where the element is imported',
  };
}

export const fixtures: readonly Fixture[] = [
  vite(8, "8.3.8", noSetting),
  vite(7, "7.3.8", noPrebundling),
  vite(6, "6.4.6", noPrebundling),
  vite(5, "5.4.21", noPrebundling),
  {
    name: "webpack5",
    project: "webpack",
    tool: { title: "webpack", package: "webpack" },
    packages: { webpack: "5.112.2", "webpack-cli": "7.3.1" },
    ways: [{ name: "build", commands: ["webpack"], serves: { folder: "." } }],
    needs: noSetting,
  },
  next("next16", "Next (Turbopack)", "16.4.6"),
  next("next16_webpack", "Next (webpack)", "16.4.6", " --webpack"),
  next("next15", "Next (webpack)", "15.5.29"),
  {
    name: "nuxt",
    project: "nuxt",
    tool: { title: "Nuxt", package: "nuxt" },
    packages: { nuxt: "4.4.5", vue: "3.5.45", "vue-router": "5.5.1", ...newerNode },
    ways: [
      {
        name: "build",
        commands: ["nuxt build"],
        serves: {
          command: (port) => `env PORT=${port} HOST=127.0.0.1 node .output/server/index.mjs`,
        },
      },
      { name: "dev", serves: { command: (port) => `nuxt dev --host 127.0.0.1 --port ${port}` } },
    ],
    needs: `\`isCustomElement\`; ${noPrebundling}: [nuxt.config.ts](#6-the-element-in-react-vue-and-svelte)`,
  },
  {
    name: "sveltekit",
    project: "sveltekit",
    tool: { title: "SvelteKit", package: "@sveltejs/kit" },
    packages: {
      "@sveltejs/adapter-static": "4.0.1",
      "@sveltejs/kit": "3.2.0",
      "@sveltejs/vite-plugin-svelte": "7.3.1",
      svelte: "5.57.3",
      vite: "8.3.8",
      ...newerNode,
    },
    ways: [
      { name: "build", commands: ["vite build"], serves: { folder: "build" } },
      { name: "dev", serves: { command: viteServer } },
    ],
    needs: noSetting,
  },
  {
    name: "astro",
    project: "astro",
    tool: { title: "Astro", package: "astro" },
    packages: { astro: "7.3.5", ...newerNode },
    ways: [
      { name: "build", commands: ["astro build"], serves: { folder: "dist" } },
      { name: "dev", serves: { command: (port) => `astro dev --host 127.0.0.1 --port ${port}` } },
    ],
    needs: "the import in a `<script>` of the page",
  },
  {
    name: "esbuild",
    project: "esbuild",
    tool: { title: "esbuild", package: "esbuild" },
    packages: { esbuild: "0.28.2" },
    ways: [
      {
        name: "build",
        commands: [
          "esbuild main.js --bundle --splitting --format=esm --outdir=dist",
          "cp -r node_modules/isosplat/assets dist/isosplat",
        ],
        serves: { folder: "." },
      },
    ],
    needs: "a copy of `node_modules/isosplat/assets`, and `setAssetBase`",
  },
  {
    name: "parcel",
    project: "parcel",
    tool: { title: "Parcel", package: "parcel" },
    packages: { parcel: "2.16.4" },
    ways: [
      {
        name: "build",
        commands: ["parcel build index.html --no-source-maps"],
        serves: { folder: "dist" },
      },
      {
        name: "dev",
        serves: {
          command: (port) => `parcel serve index.html --host 127.0.0.1 --port ${port} --no-hmr`,
        },
      },
    ],
    needs: noSetting,
  },
  react(19, react19, noSetting),
  react(
    18,
    { react: "18.3.1", "react-dom": "18.3.1" },
    "attributes, and listeners by `addEventListener`, since React 18 sets no properties of elements",
  ),
  {
    name: "typescript",
    project: "types",
    tool: { title: "TypeScript", package: "typescript" },
    packages: { typescript: "5.0.4" },
    ways: [
      {
        name: "types",
        commands: ["bundler", "node16", "node"].map((file) => `tsc -p ${file}.json`),
      },
    ],
    needs: noSetting,
  },
];

/** The table of web/npm/README.md. */
export function table(): string {
  const lines = fixtures.map(({ tool, packages, ways, needs }) => {
    const tried = ways.map(({ name }) => name).join(", ");
    return `| ${tool.title} ${packages[tool.package]} | ${tried} | ${needs} |`;
  });
  return ["| tool | tried | needs |", "|---|---|---|", ...lines].join("\n");
}
