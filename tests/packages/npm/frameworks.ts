/** A project with the README's examples for React, Vue and Svelte. */
import { mkdirSync, symlinkSync } from "node:fs";
import { dirname, join } from "node:path";
import { type Consumer, consumer, root } from "./consumer.ts";

/** The scripts of the pages NAME.html. */
export const frameworks = { react: "react.tsx", vue: "vue.js", svelte: "svelte.js" } as const;

const packages = [
  "@sveltejs/vite-plugin-svelte",
  "@types/react",
  "@types/react-dom",
  "@vitejs/plugin-vue",
  "react",
  "react-dom",
  "svelte",
  "vue",
];

/** The frameworks are those of this repository: nothing is fetched. */
export function frameworkProject(): Consumer {
  const project = consumer();
  for (const name of packages) {
    const link = join(project.folder, "node_modules", name);
    mkdirSync(dirname(link), { recursive: true });
    symlinkSync(join(root, "node_modules", name), link);
  }
  for (const [name, script] of Object.entries(frameworks)) {
    project.write(`${name}.html`, pageOf(script));
  }
  return project;
}

export function pageOf(script: string): string {
  return `<!doctype html><div id="app"></div><script type="module" src="./${script}"></script>`;
}
