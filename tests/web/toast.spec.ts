/** The short messages of the page. */
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { Toast } from "../../web/page/shell/toast.ts";

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("window", globalThis);
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

it("shows notes together that come one after the other", () => {
  const toast = new Toast(() => {});
  toast.note("The clip of the link is invalid.");
  toast.note("2 of 3 measurements were ignored.");
  const both = "The clip of the link is invalid. 2 of 3 measurements were ignored.";
  expect(toast.message).toEqual({ text: both, icon: "alert" });
  toast.note("The clip of the link is invalid.");
  expect(toast.message?.text).toBe(both);
  vi.runAllTimers();
  expect(toast.message).toBeNull();
  toast.note("Later.");
  expect(toast.message?.text).toBe("Later.");
});

it("replaces what is no note, and notes that would cover the picture", () => {
  const toast = new Toast(() => {});
  toast.done("Link copied");
  toast.note("The view is far away.");
  expect(toast.message?.text).toBe("The view is far away.");
  toast.note("x".repeat(490));
  expect(toast.message?.text).toBe("x".repeat(490));
  toast.done("Link copied");
  expect(toast.message).toEqual({ text: "Link copied", icon: "check" });
});
