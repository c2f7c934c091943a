// The spacing of a volume whose file states none: entered in the page, kept in the link and on the device.
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { demoFolder, program, type RunningServer, serve } from "./support/server.ts";
import { complete, openSection, settled } from "./support/view.ts";

const folder = mkdtempSync(join(tmpdir(), "isosplat-spacing-"));
let server: RunningServer;

test.beforeAll(async () => {
  // A ball of radius 9 in the middle of 24³ voxels.
  const voxels = Uint8Array.from({ length: 24 ** 3 }, (_, i) => {
    const [x, y, z] = [i % 24, Math.floor(i / 24) % 24, Math.floor(i / 576)];
    return Math.max(0, 190 - 10 * Math.hypot(x - 11.5, y - 11.5, z - 11.5));
  });
  const raw = join(folder, "ball_24x24x24_uint8.raw");
  writeFileSync(raw, voxels);
  execFileSync(program, ["build", raw, "-o", join(folder, "ball.isosplat")]);
  copyFileSync(join(demoFolder, "bucky.isosplat"), join(folder, "bucky.isosplat"));
  server = await serve([folder]);
});
test.afterAll(async () => {
  await server.stop();
  rmSync(folder, { recursive: true, force: true });
});

function parameter(page: Page, name: string): string | null {
  return new URL(page.url()).searchParams.get(name);
}

const facts = (page: Page) => page.locator("dl.facts");

test("is entered once; sizes, camera, planes and measurements follow", async ({ page }) => {
  const view = "isovalue=100&camera=30,20,60,11.5,11.5,11.5&plane=0,0,1,5.5";
  const measure = "measure=distance,2.5,11.5,11.5,20.5,11.5,11.5";
  await page.goto(`${server.url}?volume=ball&${view}&${measure}`);
  await complete(page);
  await openSection(page, "About this volume");
  await expect(facts(page)).toContainText("unknown: lengths are in voxels");
  await expect(page.getByText("18 voxels", { exact: true })).toBeVisible();

  await page.getByRole("button", { name: "Enter…" }).click();
  const along = (axis: string) => page.getByRole("textbox", { name: `Along ${axis}` });
  const use = page.getByRole("button", { name: "Use these distances" });
  await along("x").fill("0");
  await expect(page.getByText("Each distance is a number above 0.")).toBeVisible();
  await expect(use).toBeDisabled();
  await along("x").fill("500");
  await along("y").fill("500");
  await along("z").fill("1000");
  await page.getByRole("combobox", { name: "Unit" }).selectOption("µm");
  await use.click();

  await expect(facts(page)).toContainText("500 µm × 500 µm × 1 mm (entered)");
  await complete(page);
  await settled(page);
  expect(parameter(page, "spacing")).toBe("0.5,0.5,1");
  expect(parameter(page, "measure")).toBe("distance,1.25,5.75,11.5,10.25,5.75,11.5");
  await expect(page.getByText("9 mm", { exact: true }).first()).toBeVisible();
  expect(parameter(page, "plane")).toBe("0,0,1,5.5");
  const [, , distance = 0, ...target] = (parameter(page, "camera") ?? "").split(",").map(Number);
  expect(distance).toBeCloseTo(60 * Math.cbrt(0.25), 6);
  expect(target.slice(0, 3)).toEqual([5.75, 5.75, 11.5]);

  // Another visit has it from this device.
  await page.goto(`${server.url}?volume=ball&isovalue=100`);
  await complete(page);
  await settled(page);
  expect(parameter(page, "spacing")).toBe("0.5,0.5,1");
});

test("can be undone, changed and removed; the whole volume stays in view", async ({ page }) => {
  await page.goto(`${server.url}?volume=ball&isovalue=100`);
  await complete(page);
  await openSection(page, "About this volume");
  await openSection(page, "View");
  const undo = page.getByRole("group", { name: "Changes of the view" }).getByText("Undo");
  await expect(undo).toBeDisabled();
  expect(await undo.evaluate((chip) => Number(getComputedStyle(chip).opacity))).toBeLessThan(1);
  await openSection(page, "Measure");
  await page.getByRole("button", { name: "Point", exact: true }).click();
  await page.keyboard.press("Enter"); // takes the middle of the picture
  await page.keyboard.press("Escape");
  await expect.poll(() => parameter(page, "measure")).not.toBeNull();
  const before = parameter(page, "measure");
  const pointFacts = page.locator(".measurement-facts");
  await expect(pointFacts).toContainText("value 100");
  const normal = await pointFacts.textContent();

  const dialog = page.locator("wa-dialog");
  const along = (axis: string) => dialog.getByRole("textbox", { name: `Along ${axis}` });
  await page.getByRole("button", { name: "Enter…" }).click();
  await expect(along("x")).toHaveValue("1");
  await expect(dialog.getByRole("button", { name: "Unknown again" })).toHaveCount(0);
  await along("x").fill("3000");
  await along("y").fill("3e3");
  await along("z").fill("0,9e5");
  await dialog.getByRole("combobox", { name: "Unit" }).selectOption("Å");
  await dialog.getByRole("button", { name: "Use these distances" }).click();
  await expect.poll(() => parameter(page, "spacing")).toBe("0.0003,0.0003,0.009");
  await complete(page);
  await settled(page);
  // The default view, which shows the whole volume.
  expect(parameter(page, "camera")).toBeNull();
  const moved = parameter(page, "measure");
  expect(moved).not.toBe(before);
  await expect(pointFacts).toContainText("value 100");

  await page.keyboard.press("Control+z");
  await expect(facts(page)).toContainText("unknown: lengths are in voxels");
  await expect.poll(() => parameter(page, "spacing")).toBeNull();
  expect(parameter(page, "measure")).toBe(before);
  expect(parameter(page, "camera")).toBeNull();
  await expect(pointFacts).toHaveText(normal ?? "");
  await page.keyboard.press("Control+z");
  await expect(pointFacts).toHaveCount(0);
  await page.keyboard.press("Control+Shift+z");
  await page.keyboard.press("Control+Shift+z");
  await expect.poll(() => parameter(page, "spacing")).toBe("0.0003,0.0003,0.009");
  expect(parameter(page, "measure")).toBe(moved);

  await page.getByRole("button", { name: "Change…" }).click();
  await expect(along("x")).toHaveValue("3000");
  await expect(along("z")).toHaveValue("90000");
  await expect(dialog.getByRole("combobox", { name: "Unit" })).toHaveValue("Å");
  await dialog.getByRole("button", { name: "Unknown again" }).click();
  await expect(facts(page)).toContainText("unknown: lengths are in voxels");
  await expect.poll(() => parameter(page, "spacing")).toBeNull();
  await page.goto(`${server.url}?volume=ball&isovalue=100`);
  await complete(page);
  await openSection(page, "About this volume");
  await expect(facts(page)).toContainText("unknown: lengths are in voxels");
});

test("of a link is used; area and volume are in millimetres", async ({ page }) => {
  await page.goto(`${server.url}?volume=ball&isovalue=100&spacing=2,2,2`);
  await complete(page);
  await openSection(page, "Measure");
  await page.getByRole("button", { name: "Area and volume" }).click();
  // A ball of radius 9 voxels, whose values were rounded down: less than 3,054 voxels³ of 8 mm³.
  await expect(page.locator(".panel")).toContainText("23859 mm³");
});

test("of a link is ignored where the file states one, and a wrong one is reported", async ({
  page,
}) => {
  await page.goto(`${server.url}?volume=bucky&isovalue=100&spacing=2,2,2`);
  await complete(page);
  await settled(page);
  expect(parameter(page, "spacing")).toBeNull();
  await openSection(page, "About this volume");
  await expect(page.getByRole("button", { name: "Enter…" })).toHaveCount(0);

  await page.goto(`${server.url}?volume=ball&isovalue=100&spacing=2,0,2`);
  await complete(page);
  await expect(page.getByText("three numbers above 0, in mm")).toBeVisible();
});

/** Enters the same distance along all axes, or removes the spacing. */
async function enter(page: Page, length: string | null): Promise<void> {
  await page.getByRole("button", { name: /^(Enter|Change)…$/ }).click();
  const dialog = page.locator("wa-dialog");
  if (length === null) await dialog.getByRole("button", { name: "Unknown again" }).click();
  else {
    await dialog.getByRole("combobox", { name: "Unit" }).selectOption("mm");
    for (const axis of ["x", "y", "z"]) {
      await dialog.getByRole("textbox", { name: `Along ${axis}` }).fill(length);
    }
    await dialog.getByRole("button", { name: "Use these distances" }).click();
  }
  await expect(dialog).toHaveCount(0);
}

const kept = (page: Page) =>
  page.evaluate(() => {
    const keys = Object.keys(localStorage).filter((key) => key.includes("spacing"));
    return keys.map((key) => localStorage.getItem(key));
  });

/** Opens the ball with a query, and the section with its spacing. */
async function open(page: Page, query = ""): Promise<void> {
  await page.goto(`${server.url}?volume=ball&isovalue=100${query}`);
  await complete(page);
  await settled(page);
  await openSection(page, "About this volume");
}

test("that the visitor has entered is kept; undo and redo keep or remove no other", async ({
  page,
}) => {
  await open(page, "&spacing=2,2,2");
  await enter(page, "3");
  await expect.poll(() => parameter(page, "spacing")).toBe("3,3,3");
  await expect(page.getByRole("button", { name: "Change…" })).toBeFocused();
  expect(await kept(page)).toEqual(["3,3,3,mm"]);
  await settled(page);
  await page.keyboard.press("Control+z");
  await expect.poll(() => parameter(page, "spacing")).toBe("2,2,2");
  expect(await kept(page)).toEqual([]);
  await page.keyboard.press("Control+Shift+z");
  await expect.poll(() => parameter(page, "spacing")).toBe("3,3,3");
  expect(await kept(page)).toEqual(["3,3,3,mm"]);

  // Another link; its spacing is removed, and the visitor's own one stays.
  await open(page, "&spacing=2,2,2");
  await enter(page, null);
  await expect(facts(page)).toContainText("unknown: lengths are in voxels");
  await expect.poll(() => parameter(page, "spacing")).toBeNull();
  expect(await kept(page)).toEqual(["3,3,3,mm"]);
  await settled(page);

  // Another tab enters one before and after this one.
  const keepElsewhere = (text: string) =>
    page.evaluate((value) => {
      const key = Object.keys(localStorage).find((name) => name.includes("spacing")) ?? "";
      localStorage.setItem(key, value);
    }, text);
  await keepElsewhere("0.5,0.5,0.5,mm");
  await enter(page, "4");
  await expect.poll(() => parameter(page, "spacing")).toBe("4,4,4");
  await settled(page);
  await page.keyboard.press("Control+z");
  await expect.poll(() => parameter(page, "spacing")).toBeNull();
  await expect(facts(page)).toContainText("unknown: lengths are in voxels");
  expect(await kept(page)).toEqual(["0.5,0.5,0.5,mm"]);
  await keepElsewhere("0.7,0.7,0.7,mm");
  await page.keyboard.press("Control+Shift+z");
  await expect.poll(() => parameter(page, "spacing")).toBe("4,4,4");
  expect(await kept(page)).toEqual(["0.7,0.7,0.7,mm"]);
});

test("that an earlier page has kept is in mm", async ({ page }) => {
  await open(page);
  await enter(page, "3");
  await expect.poll(() => parameter(page, "spacing")).toBe("3,3,3");
  await page.evaluate(() => {
    const key = Object.keys(localStorage).find((name) => name.includes("spacing")) ?? "";
    localStorage.removeItem(key);
    localStorage.setItem(key.replace("entered-", ""), "0.5,0.5,2");
  });
  await open(page);
  expect(parameter(page, "spacing")).toBe("0.5,0.5,2");
});

test("moves a camera that was chosen; the whole volume stays whole", async ({ page }) => {
  await open(page, "&camera=30,20,60,11.5,11.5,11.5");
  await page.getByRole("button", { name: "Reset the view" }).click();
  await enter(page, "2");
  await expect.poll(() => parameter(page, "spacing")).toBe("2,2,2");
  await settled(page);
  const distance = () => Number((parameter(page, "camera") ?? "").split(",")[2]);
  const whole = distance();

  await open(page);
  const picture = page.getByRole("application");
  await picture.press("+");
  await picture.press("+");
  await settled(page);
  const near = distance();
  expect(near).toBeLessThan(whole);
  await enter(page, "6");
  await expect.poll(() => parameter(page, "spacing")).toBe("6,6,6");
  await settled(page);
  expect(distance() / near).toBeCloseTo(3, 3);
});

test("stays if the volume cannot be opened again, with all that moves along", async ({ page }) => {
  const own = await serve([folder]);
  await page.goto(
    `${own.url}?volume=ball&isovalue=100&measure=distance,2.5,11.5,11.5,20.5,11.5,11.5`,
  );
  await complete(page);
  await settled(page);
  await openSection(page, "About this volume");
  await enter(page, "2");
  await expect.poll(() => parameter(page, "spacing")).toBe("2,2,2");
  await complete(page);
  await settled(page);
  const address = page.url();
  // The dialog is loaded. The volume is no longer found from now on.
  await page.route(/\/v1\/volumes\/ball/, (route) => route.fulfill({ status: 404 }));
  await enter(page, "3");
  const unchanged = page.getByText("nothing was changed");
  await expect(unchanged).toBeVisible();
  expect(await kept(page)).toEqual(["2,2,2,mm"]);
  expect(page.url()).toBe(address);
  await page.unroute(/\/v1\/volumes\/ball/);
  await page.reload();
  await complete(page);
  await settled(page);
  expect(page.url()).toBe(address);
  await own.stop();
});
