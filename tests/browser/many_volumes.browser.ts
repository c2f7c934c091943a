// A list with more volumes than fit on one page.
import { copyFileSync, linkSync, mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, test } from "@playwright/test";
import { demoFolder, serve } from "./support/server.ts";

test("the list shows more on demand, and finds volumes by name", async ({ page }) => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-many-"));
  const first = join(folder, "first.isosplat");
  copyFileSync(join(demoFolder, "bucky.isosplat"), first);
  mkdirSync(join(folder, "ct"));
  for (let i = 0; i < 104; ++i) linkSync(first, join(folder, "ct", `n${i}.isosplat`));
  const server = await serve([folder]);
  try {
    await page.goto(server.url);
    const cards = page.locator("a.card");
    await expect(page.getByText("105 volumes")).toBeVisible();
    await expect(cards).toHaveCount(100);
    await page.getByRole("button", { name: "Show more" }).click();
    await expect(cards).toHaveCount(105);
    await expect(page.getByRole("button", { name: "Show more" })).toHaveCount(0);
    const search = page.getByRole("searchbox");
    await search.fill("CT n10");
    await expect(page.getByText("5 volumes with “CT n10”")).toBeVisible();
    await expect(cards).toHaveCount(5);
    await search.fill("nothing of this name");
    await expect(page.getByText("Nothing has “nothing of this name”")).toBeVisible();
    await search.fill("");
    await expect(cards).toHaveCount(100);
  } finally {
    await server.stop();
    rmSync(folder, { recursive: true, force: true });
  }
});
