import { mkdirSync, writeFileSync } from "node:fs";
import { dirname } from "node:path";
import type { Plugin } from "vite";

const names = new Set<string>();

/**
 * Writes the sorted names of the npm packages with code in the page to `file`, as JSON, for the list of components
 * (.ci/sbom.mjs). Pages and workers are built separately, each with this plugin; each build adds its names to
 * the file. `replaced`: packages that are resolved, but whose code is replaced by the project's.
 */
export function bundledPackages(file: string, replaced: string[]): Plugin {
  return {
    name: "isosplat-bundled-packages",
    apply: "build",
    generateBundle(_options, bundle) {
      for (const chunk of Object.values(bundle)) {
        if (chunk.type !== "chunk") continue;
        for (const [id, { renderedLength }] of Object.entries(chunk.modules)) {
          const [, name] = id.match(/.*\/node_modules\/((?:@[^/]+\/)?[^/]+)\//) ?? [];
          if (name && renderedLength > 0 && !replaced.includes(name)) names.add(name);
        }
      }
      mkdirSync(dirname(file), { recursive: true });
      writeFileSync(file, `${JSON.stringify([...names].sort())}\n`);
    },
  };
}
