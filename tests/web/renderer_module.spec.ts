/** The renderer module before a renderer exists: functions that need one return invalid_argument. */
import { existsSync, readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { expect, test } from "vitest";
import { instantiate, type ModuleFactory } from "../../web/core/instantiate.ts";

const folder = fileURLToPath(new URL("../../build/wasm/web/", import.meta.url));

type Exports = Record<string, (...numbers: number[]) => number> & {
  UTF8ToString(pointer: number): string;
};

test("functions that need a renderer fail without one", async () => {
  expect(existsSync(`${folder}isosplat-renderer.js`)).toBe(true);
  const { default: factory } = (await import(`${folder}isosplat-renderer.js`)) as {
    default: ModuleFactory;
  };
  const program = await WebAssembly.compile(readFileSync(`${folder}isosplat-renderer.wasm`));
  const module = await instantiate<Exports>(factory, program);
  const call = (name: string, ...numbers: number[]): number =>
    module[`_isosplat_renderer_${name}`]?.(...numbers) ?? Number.NaN;
  const message = (): string => module.UTF8ToString(call("error"));
  const statusName = (status: number): string =>
    module.UTF8ToString(module._isosplat_core_status_name?.(status) ?? 0);

  for (const [name, ...numbers] of [
    ["hold_picture"],
    ["fade", 0.5],
    ["draw", 10, 10, 0],
    ["refine", 10, 10, 0],
    ["begin_occlusion_query", 0, 0, 1],
    ["reserve_chunk", 1, 0, 0, 0, 0],
    ["set_volume", 0],
    ["begin_fade", 0],
    ["take_occlusion_query", 0],
    ["check_gpu"],
    ["warm_up"],
    ["context_restored"],
  ] as const) {
    expect(statusName(call(name, ...numbers)), name).toBe("invalid_argument");
    expect(message()).toContain("no renderer has been created");
  }
  expect(call("needs_redraw", 10, 10)).toBe(0);
});
