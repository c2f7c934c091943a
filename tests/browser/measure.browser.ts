// Picks and measurements in the page: mouse, touch, keyboard; link, files, session.
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { findings } from "./support/accessibility.ts";
import { saveData } from "./support/in_page.ts";
import { demoFolder, program, type RunningServer, serve } from "./support/server.ts";
import { complete, openSection, settled } from "./support/view.ts";

let server: RunningServer;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
});
test.afterAll(() => server.stop());

const view = "volume=bucky&isovalue=100&camera=30,20,330,63.5,63.5,63.5";

/** Area and enclosed volume of the triangles of `isosplat extract`, whose surface is closed. */
function meshExtent(name: string, isovalue: number): { area: number; volume: number } {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-mesh-"));
  const file = join(folder, "mesh.stl");
  const store = join(demoFolder, `${name}.isosplat`);
  execFileSync(program, [
    "extract",
    store,
    "--isovalue",
    String(isovalue),
    "--mesh",
    "--open",
    "-o",
    file,
  ]);
  const bytes = readFileSync(file);
  rmSync(folder, { recursive: true });
  // Binary STL: 80 bytes, the count, and for each triangle a normal, three vertices and two bytes.
  const sum = { area: 0, volume: 0 };
  for (let i = 0; i < bytes.readUInt32LE(80); ++i) {
    const vertex = (corner: number) =>
      [0, 4, 8].map((at) => bytes.readFloatLE(84 + 50 * i + 12 + 12 * corner + at));
    const [[ax = 0, ay = 0, az = 0], [bx = 0, by = 0, bz = 0], [cx = 0, cy = 0, cz = 0]] = [
      vertex(0),
      vertex(1),
      vertex(2),
    ] as [number[], number[], number[]];
    const x = (by - ay) * (cz - az) - (bz - az) * (cy - ay);
    const y = (bz - az) * (cx - ax) - (bx - ax) * (cz - az);
    const z = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
    sum.area += Math.hypot(x, y, z) / 2;
    sum.volume += (ax * x + ay * y + az * z) / 6;
  }
  return { area: sum.area, volume: Math.abs(sum.volume) };
}

async function open(page: Page, query = view): Promise<void> {
  await page.goto(`${server.url}?${query}`);
  await complete(page);
  await settled(page);
}

async function measures(page: Page): Promise<string[]> {
  await settled(page);
  return new URL(page.url()).searchParams.getAll("measure");
}

/** The middle of the picture. */
async function middle(page: Page): Promise<{ x: number; y: number }> {
  const box = await page.getByRole("application").boundingBox();
  if (!box) throw new Error("no canvas");
  return { x: Math.round(box.x + box.width / 2), y: Math.round(box.y + box.height / 2) };
}

/** Drops a session file on the page. */
async function drop(page: Page, text: string): Promise<void> {
  await expect(page.locator(".device-drop")).toBeVisible(); // the code that opens files has loaded
  await page.evaluate((content) => {
    const data = new DataTransfer();
    data.items.add(new File([content], "session.isosplat.json"));
    window.dispatchEvent(new DragEvent("drop", { dataTransfer: data, cancelable: true }));
  }, text);
}

/** Waits until the list has this many measurements. */
async function listed(page: Page, count: number): Promise<void> {
  await expect(page.locator(".measurement")).toHaveCount(count);
}

test("points, distances, paths, angles and notes, in picture, list and link", async ({ page }) => {
  await open(page);
  await openSection(page, "Measure");
  const { x, y } = await middle(page);
  const tools = page.getByRole("group", { name: "Measure", exact: true });

  await tools.getByRole("button", { name: "Point" }).click();
  await page.mouse.click(x - 10, y + 5);
  await listed(page, 1);
  await expect(page.locator(".measurement-facts").first()).toHaveText(
    /^\s*voxel [\d.]+, [\d.]+, [\d.]+ · value 100 · normal -?[\d.]+, -?[\d.]+, -?[\d.]+\s*$/,
  );

  await tools.getByRole("button", { name: "Distance" }).click();
  await page.mouse.click(x - 10, y + 5);
  await page.mouse.click(x + 40, y - 20);
  await listed(page, 2);
  // A drag turns the view and measures nothing.
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 60, y, { steps: 3 });
  await page.mouse.up();
  await listed(page, 2);

  await tools.getByRole("button", { name: "Path" }).click();
  for (const offset of [-40, 0, 40]) await page.mouse.click(x + offset, y + 8);
  await page.getByRole("button", { name: "Done" }).click();
  await listed(page, 3);
  await tools.getByRole("button", { name: "Angle" }).click();
  for (const offset of [-40, 0, 40]) await page.mouse.click(x + offset, y - 8);
  await tools.getByRole("button", { name: "Note" }).click();
  await page.mouse.click(x, y);
  await listed(page, 5);
  await page.getByRole("textbox", { name: "Text of Note 5" }).fill("a bond");
  await page.getByRole("textbox", { name: "Text of Note 5" }).press("Enter");

  await expect.poll(async () => (await measures(page))[4]).toMatch(/\|a bond$/);
  const lines = await measures(page);
  expect(lines.map((line) => line.split(",")[0])).toEqual([
    "point",
    "distance",
    "path",
    "angle",
    "note",
  ]);
  // The same point was picked twice.
  const [x0, y0, z0] = (lines[0] ?? "").split(",").slice(1).map(Number);
  expect((lines[1] ?? "").split(",").slice(1, 4).map(Number)).toEqual([x0, y0, z0]);
  const [a = 0, b = 0, c = 0, d = 0, e = 0, f = 0] = (lines[1] ?? "")
    .split(",")
    .slice(1)
    .map(Number);
  const shown = await page.locator(".measurement-value").nth(1).textContent();
  const number = Number(/([\d.]+) mm/.exec(shown ?? "")?.[1]);
  // To a tenth of a voxel; tables have all digits.
  expect(number).toBe(Math.round(10 * Math.hypot(d - a, e - b, f - c)) / 10);
  await expect(page.locator(".measure-marks text")).toHaveCount(5);
  expect(await findings(page)).toEqual([]);

  // The link contains all measurements.
  await page.reload();
  await expect(page.locator(".measure-marks text")).toHaveCount(5);
  await expect(page.locator(".measure-marks text").nth(4)).toHaveText("a bond");
  expect(await measures(page)).toEqual(lines);

  await openSection(page, "Measure");
  // A note keeps its text if the field is emptied, because a link cannot have a note without text.
  await page.getByRole("textbox", { name: "Text of Note 5" }).fill("");
  await page.getByRole("textbox", { name: "Text of Note 5" }).press("Enter");
  await expect(page.getByRole("textbox", { name: "Text of Note 5" })).toHaveValue("a bond");
  expect(await measures(page)).toEqual(lines);
  // The focus stays in the list.
  await page.getByRole("button", { name: "Remove Distance 2" }).click();
  await listed(page, 4);
  await expect(page.getByRole("button", { name: "Remove Path 2" })).toBeFocused();
  await expect.poll(async () => (await measures(page)).length).toBe(4);
  await page.getByRole("button", { name: "Remove all" }).click();
  await listed(page, 0);
  await expect(tools.getByRole("button", { name: "Point" })).toBeFocused();
  await expect.poll(() => measures(page)).toEqual([]);
  // Removing is undone like all else, one step after the other.
  await page.keyboard.press("Control+z");
  await listed(page, 4);
  await page.keyboard.press("Control+z");
  await listed(page, 5);
  await expect.poll(() => measures(page)).toEqual(lines);
  await page.keyboard.press("Control+Shift+z");
  await listed(page, 4);
});

test("points are moved along the surface, and measurements repeated", async ({ page }) => {
  await open(page);
  await openSection(page, "Measure");
  const { x, y } = await middle(page);
  const tools = page.getByRole("group", { name: "Measure", exact: true });
  await tools.getByRole("button", { name: "Distance" }).click();
  await page.mouse.click(x - 30, y + 5);
  await page.mouse.click(x + 40, y - 20);
  await tools.getByRole("button", { name: "Distance" }).click(); // ends
  await expect.poll(async () => (await measures(page)).length).toBe(1);
  const before = await measures(page);
  const camera = new URL(page.url()).searchParams.get("camera");
  const value = page.locator(".measurement-value");
  const length = await value.textContent();
  const ends = (line: string | undefined) => {
    const [, ...numbers] = (line ?? "").split(",").map(Number);
    return [numbers.slice(0, 3), numbers.slice(3)];
  };

  const moveTo = async (to: number) => {
    await page.mouse.move(x + 40, y - 20);
    await page.mouse.down();
    await page.mouse.move(to, y - 20, { steps: 5 });
  };
  await moveTo(x + 10);
  await page.keyboard.press("Escape"); // the point returns
  await page.mouse.up();
  expect(await measures(page)).toEqual(before);

  await moveTo(x + 10);
  await page.mouse.up();
  await expect.poll(() => measures(page)).not.toEqual(before);
  const moved = await measures(page);
  expect(ends(moved[0])[0]).toEqual(ends(before[0])[0]);
  expect(ends(moved[0])[1]).not.toEqual(ends(before[0])[1]);
  await expect(value).not.toHaveText(length ?? "");
  expect(new URL(page.url()).searchParams.get("camera")).toBe(camera); // no drag of the view
  await page.keyboard.press("Control+z"); // one step
  await expect.poll(() => measures(page)).toEqual(before);

  // By keyboard: it is measured again, in its place and with its text.
  await page.getByRole("textbox", { name: "Text of Distance 1" }).fill("width");
  await page.getByRole("textbox", { name: "Text of Distance 1" }).press("Enter");
  await tools.getByRole("button", { name: "Point" }).click();
  await page.mouse.click(x, y + 10);
  await listed(page, 2);
  await page.getByRole("button", { name: "Measure Distance 1 again" }).click();
  await page.keyboard.press("Enter");
  await page.mouse.click(x + 20, y + 20);
  await expect(page.locator(".measurement-value").first()).toContainText("width: ");
  await expect.poll(async () => ends((await measures(page))[0])[0]).not.toEqual(ends(before[0])[0]);
  expect((await measures(page)).map((line) => line.split(",")[0])).toEqual(["distance", "point"]);
});

test("undo and a reload keep values, normals and all digits; screen readers follow", async ({
  page,
}) => {
  await open(page);
  await openSection(page, "Measure");
  const { x, y } = await middle(page);
  const announced = page.locator(".measure-announced");
  await page.getByRole("button", { name: "Distance", exact: true }).click();
  await page.mouse.click(x - 30, y + 5);
  await expect(announced).toHaveText("1 point set");
  await page.mouse.click(x + 40, y - 20);
  await expect(announced).toHaveText(/^Distance: [\d.]+ mm$/);
  await page.keyboard.press("Escape");
  const table = async (): Promise<string> => {
    const [download] = await Promise.all([
      page.waitForEvent("download"),
      page.getByRole("button", { name: "CSV", exact: true }).click(),
    ]);
    return readFileSync(await download.path(), "utf8");
  };
  const before = await table();
  // Position, voxel, value, normal and level of both points.
  for (const line of before.split("\r\n").slice(1, 3)) {
    expect(line.split(",").slice(3, 15).map(Number)).not.toContain(Number.NaN);
    expect(line.split(",").slice(3, 15)).not.toContain("");
  }
  await expect.poll(() => measures(page)).toHaveLength(1);
  await page.getByRole("button", { name: "Remove all" }).click();
  await listed(page, 0);
  await expect(announced).toHaveText("No measurements");
  await expect.poll(() => measures(page)).toEqual([]);
  await page.keyboard.press("Control+z");
  await listed(page, 1);
  await expect(announced).toHaveText("1 measurement");
  expect(await table()).toBe(before);

  await page.getByRole("application").press("]");
  const spoken = page.locator(".announced");
  await expect(spoken).toHaveText(/^Isovalue 1\d\d/);
  const isovalue = await spoken.textContent();
  await page.getByRole("application").press("]");
  await expect(spoken).not.toHaveText(isovalue ?? "");
  await expect(spoken).toHaveText(/^Isovalue 1\d\d/);

  await settled(page);
  await page.reload();
  await complete(page);
  await openSection(page, "Measure");
  await listed(page, 1);
  await expect(announced).toHaveText("");
  expect(await table()).toBe(before);
});

test("measures by keyboard, and reports if there is no surface", async ({ page }) => {
  await open(page);
  const picture = page.getByRole("application");
  const { keyboard } = page;
  await keyboard.press("m"); // nothing has the focus
  await expect(page.locator(".measure-centre")).toBeVisible();
  await expect(page.locator(".measure-bar")).toContainText("Enter takes the middle");
  await keyboard.press("Enter");
  await expect(page.locator(".measure-marks .draft circle")).toHaveCount(1);
  await keyboard.press("Backspace");
  await expect(page.locator(".measure-marks .draft circle")).toHaveCount(0);
  await keyboard.press("Enter");
  for (let i = 0; i < 3; ++i) await keyboard.press("ArrowRight");
  await complete(page);
  await keyboard.press("Enter");
  await expect(page.locator(".measure-marks text")).toHaveText(/^[\d.]+ mm$/);
  await expect(page.locator(".measure-announced")).toHaveText(/^Distance: [\d.]+ mm$/);
  const box = await picture.boundingBox();
  if (!box) throw new Error("no canvas");
  await page.mouse.click(box.x + 5, box.y + box.height - 60);
  await expect(page.getByText("There is no surface at that place.")).toBeVisible();
  await keyboard.press("Escape");
  await expect(page.locator(".measure-centre")).toHaveCount(0);
  await expect(page.locator(".measure-bar")).toBeHidden();
  await expect.poll(() => measures(page)).toHaveLength(1);

  // A tool that is chosen in the panel listens to the same keys.
  await openSection(page, "Measure");
  await page.getByRole("button", { name: "Path", exact: true }).focus();
  await keyboard.press("Enter");
  await keyboard.press("Enter");
  for (let i = 0; i < 3; ++i) await keyboard.press("ArrowLeft");
  await complete(page);
  await keyboard.press("Enter");
  await keyboard.press("Shift+Enter");
  await listed(page, 2);
  await expect.poll(async () => (await measures(page))[1]).toMatch(/^path,/);
});

test("a double click makes a point of the surface the centre of rotation", async ({ page }) => {
  // With parallel rays, nothing else covers the point when it moves to the middle.
  await open(page, `${view}&projection=orthographic`);
  const { x, y } = await middle(page);
  await page.mouse.dblclick(x + 60, y - 30);
  await expect
    .poll(async () => {
      await settled(page);
      return new URL(page.url()).searchParams.get("camera");
    })
    .not.toBe("30,20,330,63.5,63.5,63.5");
  const target = (new URL(page.url()).searchParams.get("camera") ?? "").split(",").slice(3, 6);
  await complete(page);
  // This point is now in the middle.
  await page.getByRole("application").press("m");
  await page.getByRole("application").press("Enter");
  await page.getByRole("application").press("Enter");
  const [line = ""] = await measures(page);
  const picked = line.split(",").slice(1, 4).map(Number);
  for (const [i, value] of target.map(Number).entries()) {
    expect(Math.abs(value - (picked[i] ?? Number.NaN))).toBeLessThan(0.01);
  }
});

test("saves tables and sessions; a session that is dropped on the page opens", async ({ page }) => {
  const measured = "measure=distance,40,50,60,43,54,60|Rand&measure=spiral,1,2,3";
  await page.goto(`${server.url}?${view}&${measured}`);
  // The message is shown for a few seconds only.
  const message = page.getByText("1 of 2 measurements in the address were ignored");
  await expect(message).toBeVisible({ timeout: 30_000 });
  await complete(page);
  await settled(page);
  await openSection(page, "Measure");
  const { x, y } = await middle(page);
  await page.getByRole("button", { name: "Point", exact: true }).click();
  await page.mouse.click(x, y);
  await listed(page, 2);
  const saved = async (name: string): Promise<string> => {
    const [download] = await Promise.all([
      page.waitForEvent("download"),
      page.getByRole("button", { name, exact: true }).click(),
    ]);
    return readFileSync(await download.path(), "utf8");
  };
  const [, first, , third] = (await saved("CSV")).split("\r\n");
  expect(first).toMatch(/^1,distance,Rand,1,40,50,60,.*,,5,$/);
  expect(third).toMatch(/^2,point,,1,/);
  const rows = JSON.parse(await saved("JSON"));
  expect(rows[0]).toMatchObject({ kind: "distance", length_mm: 5, text: "Rand" });
  expect(rows[1].points[0]).toMatchObject({ value: 100, level: 0 });
  const session = await saved("Save session");
  await settled(page); // the address follows the measurements
  const before = page.url();

  await page.goto(server.url);
  await drop(page, '{"format": "isosplat-session", "version": 7}');
  await expect(page.getByRole("alert")).toContainText("expected version 1");
  // Sessions can be opened from the list of volumes as well, without dragging.
  await page.getByLabel("choose files").setInputFiles({
    name: "session.isosplat.json",
    mimeType: "application/json",
    buffer: Buffer.from(session),
  });
  await complete(page);
  await expect(page.locator(".measure-marks text")).toHaveCount(2);
  await settled(page);
  expect(page.url()).toBe(before);
  // The file has the value and the normal, which the link lacks.
  await openSection(page, "Measure");
  await expect(page.locator(".measurement-facts").last()).toContainText("value 100");
});

test("sessions have space for more measurements than addresses", { tag: "@slow" }, async ({
  page,
}) => {
  const coordinate = (i: number, by: number) => 40 + ((i * by) % 47) + 1 / 3;
  const measurements = Array.from({ length: 500 }, (_, i) => ({
    kind: "distance",
    points: [3, 7].map((by) => ({
      position: [coordinate(i, by), coordinate(i, by + 1), coordinate(i, by + 2)],
      level: 0,
    })),
  }));
  const session = {
    format: "isosplat-session",
    version: 1,
    view: `?${view}`,
    content_id: "another",
    measurements,
  };
  await page.goto(server.url);
  await drop(page, JSON.stringify(session));
  await complete(page);
  const marks = page.locator(".measure-marks text");
  await expect(marks).toHaveCount(500);
  await expect(
    page.getByText("The measurements and layers do not fit into the address"),
  ).toBeVisible();
  await settled(page);
  expect(page.url().length).toBeLessThan(7200);
  await page.reload();
  await expect(marks).toHaveCount(500);
  await openSection(page, "Measure");
  await expect(page.getByText("are of another version of this volume").last()).toBeVisible();
  const [download] = await Promise.all([
    page.waitForEvent("download"),
    page.getByRole("button", { name: "Save session", exact: true }).click(),
  ]);
  const saved = JSON.parse(readFileSync(await download.path(), "utf8"));
  expect(saved).toEqual(session);

  // Removed measurements do not return.
  await page.getByRole("button", { name: "Remove all" }).click();
  await settled(page);
  await page.reload();
  await complete(page);
  await openSection(page, "Measure");
  await expect(page.getByRole("button", { name: "Save session", exact: true })).toBeVisible();
  await listed(page, 0);
});

test("area and volume are those of the mesh that the program extracts", async ({ page }) => {
  // Only coarse levels are fetched for this view, and nothing ahead. The rest is requested for the mesh.
  await page.addInitScript(saveData);
  await open(page, "volume=bucky&isovalue=100&camera=30,20,3300,63.5,63.5,63.5");
  await openSection(page, "Measure");
  // The first response is an error, and the second one is damaged. Both are requested again.
  let answers = 0;
  await page.route(/\/v1\/volumes\/bucky/, async (route) => {
    const number = ++answers;
    if (number === 1) return route.fulfill({ status: 503, headers: { "Retry-After": "0" } });
    const response = await route.fetch();
    const body = await response.body();
    if (number === 2) for (let i = body.length >> 1; i < body.length; ++i) body[i] = 0x55;
    return route.fulfill({ response, body });
  });
  await page.getByRole("button", { name: "Area and volume" }).click();
  const shown = page.getByText(/^\s*Isovalue 100: area/);
  await expect(shown).toHaveText(
    /Isovalue 100: area\s+[\d.]+ mm²,\s+volume of greater values\s+[\d.]+ mm³ \([\d.]+ %\)/,
  );
  expect(answers).toBeGreaterThan(2);
  const [area = 0, volume = 0] = [
    ...((await shown.textContent()) ?? "").matchAll(/([\d.]+) mm[²³]/g),
  ].map((match) => Number(match[1]));
  const native = meshExtent("bucky", 100);
  expect(Math.abs(area / native.area - 1)).toBeLessThan(1e-4);
  expect(Math.abs(volume / native.volume - 1)).toBeLessThan(1e-4);
});

test("a hundred annotations follow the view", { tag: "@slow" }, async ({ page }) => {
  const notes = Array.from(
    { length: 100 },
    (_, i) => `&measure=note,${40 + (i % 10) * 5},${40 + Math.floor(i / 10) * 5},63|n${i}`,
  );
  await open(page, view + notes.join(""));
  await expect(page.locator(".measure-marks text")).toHaveCount(100);
  const place = () => page.locator(".measure-marks text").nth(57).getAttribute("x");
  const before = await place();
  await page.getByRole("application").press("ArrowRight");
  await expect.poll(place).not.toBe(before);
  await expect.poll(() => measures(page)).toHaveLength(100);
});

test.describe("on a phone", () => {
  test.use({ viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  test("taps measure, and drags turn the view", async ({ page }) => {
    await open(page);
    await page.getByRole("button", { name: "More controls" }).click();
    await openSection(page, "Measure");
    await page.getByRole("button", { name: "Distance", exact: true }).click();
    await page.getByRole("button", { name: "Fewer controls" }).click();
    const { x, y } = await middle(page);
    await page.touchscreen.tap(x - 10, y);
    await page.touchscreen.tap(x + 30, y - 10);
    await expect(page.locator(".measure-marks text")).toHaveText(/^[\d.]+ mm$/);
    await expect.poll(() => measures(page)).toHaveLength(1);
  });
});
