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
  for (const fault of [new RangeError("too far"), new TypeError("x is not a function")]) {
    const load = vi.fn().mockRejectedValue(fault);
    await expect(loadPart(load)).rejects.toBe(fault);
    expect(load).toHaveBeenCalledTimes(1);
  }
});

it.each([
  "error loading dynamically imported module: https://x/y.js",
  "Importing a module script failed.",
])("the message of another browser is known: %s", async (message) => {
  const load = vi.fn().mockRejectedValueOnce(new TypeError(message)).mockResolvedValueOnce("part");
  const part = loadPart(load);
  await vi.advanceTimersByTimeAsync(600);
  expect(await part).toBe("part");
});

/** The messages in a document of their own. */
function stubDocument() {
  const shown = new Set<object>();
  const pressed: (() => void)[] = [];
  const createElement = () => {
    const element: object = {
      setAttribute() {},
      append() {},
      addEventListener: (_: string, press: () => void) => pressed.push(press),
      remove: () => shown.delete(element),
    };
    return element;
  };
  const body = { append: (element: object) => shown.add(element) };
  vi.stubGlobal("document", { createElement, body });
  return { shown, dismiss: () => pressed.at(-1)?.() };
}

it("a message that was dismissed does not keep later ones away; attempts end, until the network returns", async () => {
  const online = new Set<() => void>();
  vi.stubGlobal("addEventListener", (_: string, listener: () => void) => online.add(listener));
  const { shown, dismiss } = stubDocument();
  const load = vi.fn().mockRejectedValue(lost);
  const part = loadPart(load);
  await vi.advanceTimersByTimeAsync(2000);
  expect(shown.size).toBe(1);
  dismiss();
  expect(shown.size).toBe(0);
  const other = loadPart(
    vi.fn().mockRejectedValueOnce(lost).mockRejectedValueOnce(lost).mockResolvedValueOnce(1),
  );
  await vi.advanceTimersByTimeAsync(1000);
  expect(shown.size).toBe(1);
  dismiss();
  await vi.advanceTimersByTimeAsync(1000);
  await other;
  expect(shown.size).toBe(0);

  await vi.advanceTimersByTimeAsync(3600_000);
  expect(load).toHaveBeenCalledTimes(20);
  expect(shown.size).toBe(1);
  load.mockResolvedValueOnce("part");
  for (const listener of online) listener();
  expect(await part).toBe("part");
  expect(shown.size).toBe(0);
});
