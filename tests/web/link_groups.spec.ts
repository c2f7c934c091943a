// What linked elements share.
import { expect, test } from "vitest";
import {
  type LinkedView,
  LinkGroups,
  linkedParts,
  readLink,
  sharedBy,
} from "../../web/element/link_groups.ts";

test("a link is a name, which shares all parts, or a name with parts", () => {
  expect(readLink("brains")).toEqual({ group: "brains", parts: new Set(linkedParts) });
  expect(readLink("brains: camera, time")).toEqual({
    group: "brains",
    parts: new Set(["camera", "time"]),
  });
  for (const wrong of ["brains:colour", "brains:", ":camera", "a:b:c", "brains:camera,"]) {
    expect(readLink(wrong), wrong).toBeUndefined();
  }
});

test("elements of one group share what their links have in common", () => {
  const groups = new LinkGroups();
  const received: LinkedView[] = [];
  const all = { receive: () => {} };
  const some = { receive: (view: LinkedView) => received.push(view) };
  groups.join("g", all);
  groups.join("g", some);
  groups.send("g", all, { isovalues: [1], time: 2 });
  const link = readLink("g:time");
  expect(link && received.map((view) => sharedBy(link, view))).toEqual([{ time: 2 }]);
});
