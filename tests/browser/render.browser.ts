// Compares the renderer module in Chromium with the native renderer: both run on llvmpipe, so
// almost every pixel is equal. Threshold: at most 0.1 % of the pixels differ by more than 2 of 255
// in any channel.
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createServer, type Server } from "node:http";
import type { AddressInfo } from "node:net";
import { tmpdir } from "node:os";
import { extname, join } from "node:path";
import { expect, test } from "@playwright/test";
import type * as Layouts from "../../build/wasm/web/layouts.js";
import { defaultLook } from "../../web/viewer/types.ts";

const modules = "build/wasm/web";
const fixture = "build/release/tests/native/isosplat_render_fixture";
const types: Record<string, string> = {
  ".js": "text/javascript",
  ".wasm": "application/wasm",
  ".html": "text/html",
};
const kinds = [
  "quad",
  "ellipse",
  "exact",
  "exact, exact shading",
  "quad, lit at once",
  "exact, at rest",
  "exact with caps, at rest",
  "triangles",
  "triangles, lit at once",
  "field, ellipse",
  "field, exact, logarithmic",
  "field, quad, in steps",
  "field, quad, lit at once",
  "field, triangles",
  "field, triangles, lit at once",
  "field with lines, exact",
  "field with lines, quad, lit at once",
  "field with lines, triangles",
  "field with lines, ellipse",
];

let folder = "";
let server: Server;
let origin = "";
type Camera = Parameters<typeof Layouts.writeCamera>[2];
let camera: Camera;

test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-render-"));
  const printed = execFileSync(fixture, [folder], { encoding: "utf8" });
  const [x = 0, y = 0, z = 0, distance = 1] = printed.trim().split(" ").map(Number);
  camera = {
    target: [x, y, z],
    distance,
    azimuth: 30,
    elevation: 20,
    roll: 0,
    fieldOfView: 30,
    orthographic: 0,
  };
  server = createServer((request, response) => {
    const path = request.url ?? "/";
    if (path === "/") {
      response.setHeader("Content-Type", "text/html");
      response.end(
        '<link rel="icon" href="data:,"><canvas id="view" width="256" height="256"></canvas>',
      );
      return;
    }
    const root = path.startsWith("/fixture/") ? folder : modules;
    try {
      const bytes = readFileSync(join(root, path.replace("/fixture/", "/")));
      response.setHeader("Content-Type", types[extname(path)] ?? "application/octet-stream");
      response.end(bytes);
    } catch {
      response.statusCode = 404;
      response.end();
    }
  });
  await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
  origin = `http://127.0.0.1:${(server.address() as AddressInfo).port}`;
});

test.afterAll(() => {
  server.close();
  rmSync(folder, { recursive: true });
});

test("draws what the native renderer draws, before and after a lost context", async ({ page }) => {
  const messages: string[] = [];
  page.on("console", (message) => messages.push(message.text()));
  await page.goto(origin);
  const result = await page.evaluate(
    async ([cameraRecord, kindCount, look]) => {
      const layouts: typeof Layouts = await import(`${location.origin}/layouts.js`);
      const { default: create } = await import(`${location.origin}/isosplat-renderer.js`);
      const m = await create({ locateFile: (f: string) => `${location.origin}/${f}` });
      const canvas = document.querySelector("canvas") as HTMLCanvasElement;
      const check = (status: number) => {
        if (status !== 0) throw new Error(m.UTF8ToString(m._isosplat_renderer_error()));
      };
      const heap = () => new DataView(m.HEAPU8.buffer);
      /** Records in the heap, one after the other. */
      const records = <T>(
        bytes: number,
        write: (data: DataView, at: number, record: T) => void,
        ...list: T[]
      ): number => {
        const at = m._malloc(bytes * list.length);
        for (const [i, record] of list.entries()) write(heap(), at + bytes * i, record);
        return at;
      };
      check(m._isosplat_renderer_create(m.stringToNewUTF8("#view")));
      const gl = canvas.getContext("webgl2") as WebGL2RenderingContext;
      const debug = gl.getExtension("WEBGL_debug_renderer_info");
      const renderer = String(gl.getParameter(debug?.UNMASKED_RENDERER_WEBGL ?? gl.RENDERER));
      const floatTargets = gl.getExtension("EXT_color_buffer_float") !== null;
      const samples = new Uint8Array(await (await fetch("/fixture/samples.bin")).arrayBuffer());
      const clusters = new Uint8Array(await (await fetch("/fixture/clusters.bin")).arrayBuffer());
      const field = new Uint8Array(await (await fetch("/fixture/field.bin")).arrayBuffer());
      const volume = records(layouts.volumeBytes, layouts.writeVolume, {
        voxels: [60, 50, 30],
        spacing: [1, 1.25, 2],
        origin: [0, 0, 0],
        direction: [1, 0.6, 0, 0, 0.8, 0, 0, 0, 1],
        valueOffset: 0,
        valueScale: 1,
      });
      check(m._isosplat_renderer_set_volume(0, volume));
      const block = records(layouts.blockBytes, layouts.writeBlock, { level: 0, block: [0, 0, 0] });
      const add = () => {
        const at = m._malloc(clusters.length);
        m.HEAPU8.set(clusters, at);
        const offset = m._malloc(8);
        check(m._isosplat_renderer_reserve_chunk(0, 7, block, at, clusters.length, offset));
        gl.bufferSubData(gl.ARRAY_BUFFER, m.HEAPF64[offset / 8], samples);
        m._free(at);
        const mapping = records(layouts.fieldMappingBytes, layouts.writeFieldMapping, {
          valueOffset: 0,
          valueScale: 0.5,
          hasMissing: 1,
        });
        check(m._isosplat_renderer_set_field(0, mapping));
        const count = field.length / layouts.packedSampleBytes;
        check(m._isosplat_renderer_reserve_chunk_field(0, 7, count, offset));
        gl.bufferSubData(gl.ARRAY_BUFFER, m.HEAPF64[offset / 8], field);
        const drawn = m._malloc(layouts.drawnChunkBytes);
        m.HEAPU8.fill(0xff, drawn, drawn + layouts.drawnChunkBytes);
        heap().setUint32(drawn + layouts.drawnChunkOffsets.handle, 7, true);
        m._isosplat_renderer_set_visible(0, drawn, 1);
        m._free(drawn);
      };
      add();
      const near = { ...cameraRecord, distance: cameraRecord.distance / 2 };
      const cameras = [cameraRecord, near].map((camera) =>
        records(layouts.cameraBytes, layouts.writeCamera, camera),
      );
      const isosurfaces = records(
        layouts.isosurfaceBytes,
        layouts.writeIsosurface,
        { isovalue: 1500.5, colour: [0.9, 0.3, 0.2], opacity: 1 },
        { isovalue: 2500, colour: [0.85, 0.8, 0.7], opacity: 0.4 },
      );
      const clip = (caps: number) => {
        const low: [number, number, number] = [0, 0, 0];
        const high: [number, number, number] = [0.8, 1, 1];
        const box = records(layouts.clipBoxBytes, layouts.writeClipBox, { low, high, caps });
        m._isosplat_renderer_set_clipping(box, 0, 0);
        m._free(box);
      };

      const pixels = new Uint8Array(4 * 256 * 256);
      const differing = async () => {
        const shares: number[] = [];
        for (let kind = 0; kind < kindCount; ++kind) {
          const atOnce = [4, 8, 12, 14, 16].includes(kind);
          const atRest = kind === 5 || kind === 6;
          m._isosplat_renderer_set_camera(cameras[[7, 8, 13, 14, 17].includes(kind) ? 1 : 0]);
          clip(kind === 6 ? 1 : 0);
          const splats = [0, 1, 2, 2, 0, 2, 2, 0, 0, 1, 2, 0, 0, 0, 0, 2, 0, 0, 1][kind];
          m._isosplat_renderer_set_splats(splats, kind === 3 ? 1 : 0);
          m._isosplat_renderer_set_isosurfaces(0, isosurfaces, atOnce ? 1 : 2);
          const appearance = records(layouts.appearanceBytes, layouts.writeAppearance, {
            colourLow: 300,
            colourHigh: 700,
            colourBy: kind >= 9 ? layouts.colourByNames.indexOf("field") : 0,
            colourMap: 0,
            background: [1, 1, 1, 1],
            fieldMissing: [1, 0, 1],
            fieldScale: kind === 10 ? 1 : 0,
            fieldSteps: kind === 11 ? 6 : 0,
            fieldLines: kind >= 15 ? 37 : 0,
            eyeDome: atOnce ? 0 : look.eyeDome,
          });
          m._isosplat_renderer_set_appearance(appearance);
          m._free(appearance);
          const light = records(layouts.lightBytes, layouts.writeLight, look.light);
          m._isosplat_renderer_set_light(light);
          m._free(light);
          check(m._isosplat_renderer_draw(256, 256, 0));
          while (atRest && m._isosplat_renderer_can_refine(256, 256) === 1)
            check(m._isosplat_renderer_refine(256, 256, 0));
          gl.readPixels(0, 0, 256, 256, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
          const native = new Uint8Array(await (await fetch(`/fixture/${kind}.rgba`)).arrayBuffer());
          let count = 0;
          for (let y = 0; y < 256; ++y) {
            for (let x = 0; x < 256; ++x) {
              const a = 4 * (256 * y + x);
              const b = 4 * (256 * (255 - y) + x);
              if (
                [0, 1, 2, 3].some((c) => Math.abs((pixels[a + c] ?? 0) - (native[b + c] ?? 0)) > 2)
              )
                ++count;
            }
          }
          shares.push(count / 65536);
        }
        return shares;
      };
      const before = await differing();
      const redrawWhenStill = m._isosplat_renderer_needs_redraw(256, 256);

      const lose = gl.getExtension("WEBGL_lose_context") as WEBGL_lose_context;
      const event = (name: string) =>
        new Promise<void>((resolve) =>
          canvas.addEventListener(
            name,
            (e) => {
              e.preventDefault();
              resolve();
            },
            { once: true },
          ),
        );
      const lost = event("webglcontextlost");
      lose.loseContext();
      await lost;
      m._isosplat_renderer_context_lost();
      const statusWhileLost = m._isosplat_renderer_draw(256, 256, 0);
      const restored = event("webglcontextrestored");
      await new Promise((resolve) => setTimeout(resolve, 50));
      lose.restoreContext();
      await restored;
      check(m._isosplat_renderer_context_restored());
      add();
      const after = await differing();
      const error = gl.getError();
      m._isosplat_renderer_destroy();
      return { before, after, redrawWhenStill, statusWhileLost, renderer, floatTargets, error };
    },
    [camera, kinds.length, defaultLook] as const,
  );
  expect(result.renderer).toContain("llvmpipe");
  expect(result.floatTargets).toBe(true);
  expect(result.error).toBe(0);
  for (const [kind, name] of kinds.entries()) {
    expect(result.before[kind], name).toBeLessThan(0.001);
    expect(result.after[kind], `${name}, context restored`).toBeLessThan(0.001);
  }
  expect(result.redrawWhenStill).toBe(0);
  expect(result.statusWhileLost).not.toBe(0);
  expect(messages).toEqual([]);
});
