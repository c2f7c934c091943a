// The parts of <isosplat-viewer> that need no browser, and its reference.
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { describe, expect, it } from "vitest";
import { ContextPool, type ContextUser } from "../../web/element/context_pool.ts";
import { sourceOf } from "../../web/element/element_source.ts";
import { ElementTime } from "../../web/element/element_time.ts";
import { type LinkedView, LinkGroups } from "../../web/element/link_groups.ts";
import { ServerSource } from "../../web/stream/index.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));

class User implements ContextUser {
  isVisible = true;
  isBusy = true;
  isFocused = false;
  /** 0: without a context. */
  budget = 0;
  grant(samples: number): void {
    this.budget = samples;
  }
  setSampleBudget(samples: number): void {
    this.budget = samples;
  }
  async suspend(): Promise<void> {
    this.budget = 0;
  }
}

const settled = () => new Promise((resolve) => setTimeout(resolve));

describe("the contexts of a page", () => {
  const make = (limit: number, count: number) => {
    const pool = new ContextPool(limit, () => 1200);
    const users = Array.from({ length: count }, () => new User());
    for (const user of users) pool.request(user);
    return { pool, users };
  };
  const budgets = (users: readonly User[]) => users.map(({ budget }) => budget);

  it("share the budget, and divide it again when one of them is released", () => {
    const { pool, users } = make(4, 3);
    expect(budgets(users)).toEqual([400, 400, 400]);
    if (users[1]) pool.release(users[1]);
    expect(budgets(users)).toEqual([600, 400, 600]);
  });

  it("are not taken from views that are still being drawn", async () => {
    const { pool, users } = make(2, 3);
    const [first, second, third] = users as [User, User, User];
    await settled();
    expect(budgets(users)).toEqual([600, 600, 0]);
    first.isBusy = false;
    pool.changed();
    await settled();
    expect(budgets(users)).toEqual([0, 600, 600]);
    // The first one has a picture. It gets a context again when it is used.
    third.isBusy = false;
    pool.changed();
    await settled();
    expect(budgets(users)).toEqual([0, 600, 600]);
    pool.request(first, true);
    await settled();
    expect(budgets(users)).toEqual([600, 600, 0]);
    expect(second.budget).toBe(600);
  });

  it("are taken first from views out of sight, and from any view if a visitor needs one", async () => {
    const { pool, users } = make(2, 4);
    const [, second, third] = users as [User, User, User, User];
    second.isVisible = false;
    pool.changed();
    await settled();
    expect(budgets(users)).toEqual([600, 0, 600, 0]);
    second.isVisible = true;
    pool.request(second, true);
    await settled();
    // If both are busy, the least recently used one loses its context.
    expect(budgets(users)).toEqual([0, 600, 600, 0]);
    expect(third.budget).toBe(600);
  });
});

describe("a view that is being suspended", () => {
  /** One holder, whose context is being taken for another view. */
  const suspending = () => {
    const pool = new ContextPool(1, () => 1200);
    const [holder, other] = [new User(), new User()];
    pool.request(holder);
    holder.isBusy = false;
    pool.request(other);
    return { pool, holder, other };
  };

  it("gets a context again if it requests one in the meantime", async () => {
    const { pool, holder, other } = suspending();
    pool.request(holder);
    await settled();
    expect([holder.budget, other.budget]).toEqual([0, 1200]);
    other.isBusy = false;
    pool.changed();
    await settled();
    expect([holder.budget, other.budget]).toEqual([1200, 0]);
  });

  it("gets one before others if a visitor waits for it", async () => {
    const { pool, holder, other } = suspending();
    pool.request(holder, true);
    holder.isBusy = true;
    await settled();
    expect([holder.budget, other.budget]).toEqual([1200, 0]);
  });
});

it("a view with the focus keeps its context", async () => {
  const pool = new ContextPool(2, () => 1200);
  const [focused, other, third] = [new User(), new User(), new User()];
  focused.isFocused = true;
  focused.isVisible = false;
  for (const user of [focused, other]) pool.request(user);
  pool.request(third, true);
  await settled();
  expect([focused.budget, other.budget, third.budget]).toEqual([600, 0, 600]);
});

describe("the step of an element", () => {
  /** `changes`: the steps, and their values for the group; undefined if the group has chosen them. */
  const make = () => {
    const changes: [step: number, value: number | undefined][] = [];
    const time = new ElementTime({
      viewer: () => null,
      wake: () => {},
      shown: () => {},
      changed: (...change) => void changes.push(change),
    });
    return { time, changes };
  };
  /** Opens a scene with these values in a viewer, which is disposed of afterwards. */
  const openScene = (time: ElementTime, values: readonly number[]) => {
    const shown = { values, step: time.firstOf(values) ?? 0, on: () => {} };
    const viewer = { on: (_: string, listener: (detail: unknown) => void) => listener(shown) };
    time.attach(viewer as unknown as Parameters<ElementTime["attach"]>[0]);
  };

  it("is that of the scene unless it was chosen", () => {
    const { time } = make();
    expect(time.firstOf([0, 1, 2])).toBeUndefined();
    time.step = 2;
    expect(time.firstOf([0, 1, 2])).toBe(2);
    time.reset(undefined);
    expect(time.firstOf([0, 1, 2])).toBeUndefined();
    time.reset(1);
    expect(time.firstOf([0, 1, 2])).toBe(1);
  });

  it("is the nearest to the time of the group, even if the group chose it before a scene is open", () => {
    const { time, changes } = make();
    time.receive(19);
    expect(time.firstOf([0, 10, 20, 30])).toBe(2);
    openScene(time, [0, 10, 20, 30]);
    expect(changes).toEqual([]);
    time.receive(8);
    expect(time.step).toBe(1);
    // A step that the group has chosen is not reported back to the group.
    expect(changes).toEqual([[1, undefined]]);
    time.step = 99;
    expect(time.step).toBe(3);
    expect(changes.at(-1)).toEqual([3, 30]);
    expect(time.chosenValue).toBe(30);
  });
});

describe("linked elements", () => {
  it("receive the changes of other elements of their group", () => {
    const groups = new LinkGroups();
    const received: [string, LinkedView][] = [];
    const member = (name: string) => ({
      receive: (view: LinkedView) => void received.push([name, view]),
    });
    const [a, b, other] = [member("a"), member("b"), member("other")];
    groups.join("group", a);
    groups.join("group", b);
    groups.join("another", other);
    groups.send("group", a, { isovalues: [1] });
    expect(received).toEqual([["b", { isovalues: [1] }]]);
    // An element that joins later begins with the view of the group.
    expect(groups.join("group", member("c"))).toEqual({ isovalues: [1] });
    groups.leave("group", a);
    groups.send("group", a, { isovalues: [2] });
    expect(received.length).toBe(1);
  });

  it("take from a new member only the settings that their view lacks", () => {
    const groups = new LinkGroups();
    const received: LinkedView[] = [];
    groups.join("group", { receive: (view) => void received.push(view) });
    const member = { receive: () => {} };
    expect(groups.join("group", member, { isovalues: [1] })).toEqual({});
    expect(groups.join("group", { receive: () => {} }, { isovalues: [2] })).toEqual({
      isovalues: [1],
    });
    expect(received).toEqual([{ isovalues: [1] }]);
  });
});

describe("the address of a volume", () => {
  const base = "https://page.example/folder/index.html";
  it.each([
    ["head.isosplat", "https://page.example/folder/head.isosplat", false],
    ["v1/volumes/head", "head", true],
    ["https://host.example/ct/v1/volumes/a%20b?exp=1&sig=2", "a b", true],
    [
      "https://host.example/v1/volumes/head/file",
      "https://host.example/v1/volumes/head/file",
      false,
    ],
  ])("%s", (src, name, isOfServer) => {
    const source = sourceOf(src, base);
    expect(source?.name).toBe(name);
    expect(source instanceof ServerSource).toBe(isOfServer);
  });

  it.each(["ftp://host/head.isosplat", "https://", "v1/volumes/%zz"])("%s is refused", (src) => {
    expect(sourceOf(src, base)).toBeUndefined();
  });
});

it("the reference matches the code: npm run reference", () => {
  const script = join(root, "web/bundle/element_reference.mjs");
  const printed = execFileSync(process.execPath, [script, "--print"], { encoding: "utf8" });
  expect(readFileSync(join(root, "web/element/REFERENCE.md"), "utf8")).toBe(printed);
  for (const part of ["`src`", "`isovaluechange`", "`screenshot(): Promise<Blob>`"]) {
    expect(printed).toContain(part);
  }
}, 60_000);
