// Parts of the page's program are loaded again after the network failed. The messages are tested in Chromium.
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { loadPart } from "../../web/page/shell/load_part.ts";

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("addEventListener", () => {});
  vi.stubGlobal("removeEventListener", () => {});
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const lost = new TypeError("Failed to fetch dynamically imported module: x.js");

it("an import that fails is repeated until it succeeds", async () => {
  const load = vi.fn().mockRejectedValueOnce(lost).mockResolvedValueOnce("part");
  const part = loadPart(load);
  await vi.advanceTimersByTimeAsync(400);
  expect(load).toHaveBeenCalledTimes(1);
  await vi.advanceTimersByTimeAsync(200);
  expect(await part).toBe("part");
  expect(load).toHaveBeenCalledTimes(2);
});

it("the network's return ends the wait", async () => {
  const online: (() => void)[] = [];
  vi.stubGlobal("addEventListener", (_: string, listener: () => void) => online.push(listener));
  const load = vi.fn().mockRejectedValueOnce(lost).mockResolvedValueOnce("part");
  const part = loadPart(load);
  await vi.advanceTimersByTimeAsync(1);
  for (const listener of online) listener();
  expect(await part).toBe("part");
});

it("another fault is not repeated", async () => {
  const load = vi.fn().mockRejectedValue(new RangeError("a fault of the program"));
  await expect(loadPart(load)).rejects.toThrow("a fault of the program");
  expect(load).toHaveBeenCalledTimes(1);
});
