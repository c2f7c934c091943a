/** The example of server/HTTP.md: NumPy reads the points of an isosurface from a server. */
import { execFile, spawnSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";
import { expect, test } from "vitest";
import { serve } from "../browser/support/server.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));
const python = "/usr/bin/python3";
const hasNumpy = spawnSync(python, ["-c", "import numpy"]).status === 0;

test.skipIf(!hasNumpy)(
  "NumPy reads samples as HTTP.md shows",
  async () => {
    const document = readFileSync(join(root, "server/HTTP.md"), "utf8");
    const example = /```python\n([^`]*)```/.exec(document)?.[1] ?? "";
    expect(example).toContain("numpy.load");
    const server = await serve([join(root, "tests/golden/v1.0/u8.isosplat")]);
    try {
      const base = server.url.slice(0, -1);
      const volume = (await (await fetch(`${base}/v1/volumes/u8`)).json()) as {
        urls: { samples: string };
      };
      const url = `${base}${volume.urls.samples}?isovalue=100`;
      const head = await fetch(url, { method: "HEAD" });
      const count = Number(head.headers.get("x-isosplat-points"));
      expect(count).toBeGreaterThan(0);
      const program = `import io, json, numpy, urllib.request
url = ${JSON.stringify(url)}
${example}
lengths = numpy.linalg.norm(points["normals"], axis=1)
print(json.dumps([points.shape, str(points.dtype), float(lengths.min()), float(lengths.max())]))`;
      const { stdout } = await promisify(execFile)(python, ["-c", program]);
      const [shape, type, shortest, longest] = JSON.parse(stdout) as [
        number[],
        string,
        number,
        number,
      ];
      expect(shape).toEqual([count]);
      expect(type).toBe(head.headers.get("x-isosplat-dtype"));
      expect(shortest).toBeGreaterThan(0.9999);
      expect(longest).toBeLessThan(1.0001);
    } finally {
      await server.stop();
    }
  },
  60_000,
);
