import { expect, it } from "vitest";
import { ViewHistory } from "../../web/page/address/view_history.ts";

it("goes back and forth through the views at rest", () => {
  const history = new ViewHistory<number>();
  expect(history.undo()).toBeUndefined();
  for (const view of [1, 2, 2, 3]) history.rested(String(view), view);
  expect([history.undo(), history.undo(), history.undo()]).toEqual([2, 1, undefined]);
  expect(history.canUndo).toBe(false);
  expect([history.redo(), history.redo(), history.redo()]).toEqual([2, 3, undefined]);
  // A restored view that comes to rest is not another one.
  expect(history.undo()).toBe(2);
  history.rested("2", 2);
  expect(history.canRedo).toBe(true);
  // Another view discards the undone views.
  history.rested("4", 4);
  expect(history.canRedo).toBe(false);
  expect([history.undo(), history.undo()]).toEqual([2, 1]);
});

it("takes no step to a view that replaces the present one", () => {
  const history = new ViewHistory<number>();
  for (const view of [1, 2]) history.rested(String(view), view);
  history.replacePresent();
  history.rested("3", 3);
  expect([history.undo(), history.undo(), history.redo()]).toEqual([1, undefined, 3]);
});

it("keeps the newest of views that are the same", () => {
  const history = new ViewHistory<string>();
  history.rested("1", "rounded");
  history.rested("1", "with all digits");
  history.rested("2", "other");
  expect(history.undo()).toBe("with all digits");
  // That it rests does not end redo.
  history.rested("1", "again");
  expect([history.redo(), history.undo()]).toEqual(["other", "again"]);
});

it("keeps the last hundred", () => {
  const history = new ViewHistory<number>();
  for (let view = 0; view < 500; ++view) history.rested(String(view), view);
  let last = Number.NaN;
  for (let view = history.undo(); view !== undefined; view = history.undo()) last = view;
  expect(last).toBe(399);
});
