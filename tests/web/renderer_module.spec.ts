/** The renderer's module before it has a view on a canvas: every function says so. */
import { existsSync, readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { expect, test } from "vitest";
import { instantiate, type ModuleFactory } from "../../web/core/instantiate.ts";

const folder = fileURLToPath(new URL("../../build/wasm/web/", import.meta.url));

type Exports = Record<string, (...numbers: number[]) => number> & {
  UTF8ToString(pointer: number): string;
};

test("functions that need a view fail without one", async () => {
  expect(existsSync(`${folder}isosplat-renderer.js`)).toBe(true);
  const { default: factory } = (await import(`${folder}isosplat-renderer.js`)) as {
    default: ModuleFactory;
  };
  const program = await WebAssembly.compile(readFileSync(`${folder}isosplat-renderer.wasm`));
  const view = await instantiate<Exports>(factory, program);
  const call = (name: string, ...numbers: number[]): number =>
    view[`_isosplat_renderer_${name}`]?.(...numbers) ?? Number.NaN;
  const message = (): string => view.UTF8ToString(call("error"));
  const statusName = (status: number): string =>
    view.UTF8ToString(view._isosplat_core_status_name?.(status) ?? 0);

  // Of begin_fade, 1 says that a fade has begun.
  expect(call("begin_fade")).toBeLessThan(0);
  expect(statusName(-call("begin_fade"))).toBe("invalid_argument");
  expect(message()).toContain("no view has been created");
  for (const [name, ...numbers] of [
    ["hold_picture"],
    ["fade", 0.5],
    ["draw", 10, 10, 0],
    ["refine", 10, 10, 0],
    ["begin_occlusion_query", 0, 0, 1],
    ["add_chunk", 1, 0, 0, 0, 0, 0, 0],
    ["check_gpu"],
    ["warm_up"],
    ["context_restored"],
  ] as const) {
    expect(statusName(call(name, ...numbers)), name).toBe("invalid_argument");
  }
  expect(call("take_occlusion_query")).toBe(-1);
  expect(call("needs_redraw", 10, 10)).toBe(0);
});
