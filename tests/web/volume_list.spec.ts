/**
 * The list of volumes: compares the pages and searches of a server with those of a static site's
 * catalog.
 */
import { copyFileSync, mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { afterAll, beforeAll, expect, test } from "vitest";
import {
  type ListQuery,
  selectVolumes,
  type VolumeList,
} from "../../web/page/shell/volumes_api.ts";
import { type RunningServer, serve } from "../browser/support/server.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "isosplat-list-"));
let server: RunningServer;
let base: string;

beforeAll(async () => {
  for (const name of ["head", "ct/head", "ct/2024/Knee", "ct/2024/foot", "mr/head"]) {
    const path = join(folder, `${name}.isosplat`);
    mkdirSync(dirname(path), { recursive: true });
    copyFileSync(join(root, "tests/golden/v1.0/u8.isosplat"), path);
  }
  server = await serve([folder]);
  base = `${server.url}v1/volumes`;
}, 60_000);

afterAll(async () => {
  await server.stop();
  rmSync(folder, { recursive: true, force: true });
});

async function list(query: Record<string, string> = {}): Promise<VolumeList> {
  const answer = await fetch(`${base}?${new URLSearchParams(query)}`.replaceAll("+", "%20"));
  return (await answer.json()) as VolumeList;
}

test("a static site selects the same volumes as a server", async () => {
  const all = await list();
  expect(all.volumes.map(({ name }) => name)).toEqual([
    "ct~2024~Knee",
    "ct~2024~foot",
    "ct~head",
    "head",
    "mr~head",
  ]);
  const queries: ListQuery[] = [
    {},
    { query: "head" },
    { query: " HEAD  ct " },
    { query: "ct~2024", limit: 1 },
    { query: "ct~2024", offset: 1, limit: 1 },
    { query: "knee" },
    { query: "nothing" },
    { offset: 4 },
    { offset: 5 },
    { limit: 2 },
  ];
  for (const query of queries) {
    const entries = Object.entries(query).map(([key, value]) => [key, String(value)]);
    const { volumes, total, fileBytes } = await list(Object.fromEntries(entries));
    expect(selectVolumes(all.volumes, query)).toEqual({ volumes, total, fileBytes });
  }
});
