// Pictures of any size, in the real page.
import { readFileSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { expect, type Locator, type Page, test } from "@playwright/test";
import { drawNatively } from "./support/native_picture.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { compare, complete, savedPicture, settled } from "./support/view.ts";

let server: RunningServer;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
});
test.afterAll(() => server.stop());

const camera = "40,25,330,63.5,63.5,63.5";

/** Opens a volume, and the dialog. */
async function openDialog(page: Page, view = camera): Promise<void> {
  await page.goto(
    `${server.url}?volume=bucky&isovalue=100&camera=${view}&kind=exact&background=ffffff`,
  );
  await complete(page);
  await settled(page);
  await page.getByRole("application").focus();
  await page.keyboard.press("Shift+S");
  await expect(page.getByRole("dialog", { name: "Pictures and films" })).toBeVisible();
}

function status(page: Page): Locator {
  return page.locator(".capture-form [role=status]");
}

async function chooseSize(page: Page, width: number, height: number): Promise<void> {
  await page.getByLabel("Size in pixels").selectOption("own");
  await page.getByLabel("Width", { exact: true }).fill(String(width));
  await page.getByLabel("Height", { exact: true }).fill(String(height));
}

async function save(page: Page): Promise<Buffer> {
  const [download] = await Promise.all([
    page.waitForEvent("download", { timeout: 150_000 }),
    page.getByRole("button", { name: "Save", exact: true }).click(),
  ]);
  return readFileSync(await download.path());
}

test("a picture that is drawn in parts equals the program's picture", async ({ page }) => {
  test.setTimeout(180_000);
  const [width, height] = [1150, 190];
  await openDialog(page);
  await chooseSize(page, width, height);
  const png = await save(page);
  const view = { isovalue: 100, camera, kind: "exact", width, height } as const;
  const native = drawNatively(resolve(demoFolder, "bucky.isosplat"), view);
  const found = await compare(page, png, native);
  expect([found.width, found.height]).toEqual([width, height]);
  expect(found.covered).toBeGreaterThan(0.02);
  expect(found.differing).toBeLessThan(0.001);
});

test("Escape keeps a film that is being made; Cancel ends it", async ({ page }) => {
  await page.setViewportSize({ width: 420, height: 400 });
  await openDialog(page);
  await page.getByLabel("What").selectOption({ label: "Film: once around" });
  const seconds = page.getByLabel("Seconds");
  await seconds.fill("7,5");
  await expect(status(page)).toContainText("225 frames");
  await page.getByLabel("File").selectOption({ label: "PNG files in a ZIP" });
  const opacity = () => seconds.evaluate((input) => Number(getComputedStyle(input).opacity));
  expect(await opacity()).toBe(1);
  await page.getByRole("button", { name: "Save", exact: true }).click();
  const cancel = page.getByRole("button", { name: "Cancel", exact: true });
  await expect(cancel).toBeVisible();
  await expect(seconds).toBeDisabled();
  expect(await opacity()).toBeLessThan(1);
  await page.keyboard.press("Escape");
  await expect(cancel).toBeFocused();
  await expect(page.getByRole("dialog", { name: "Pictures and films" })).toBeVisible();
  await expect(status(page)).not.toContainText("Cancelled");
  const asks = () =>
    page.evaluate(() => {
      const event = new Event("beforeunload", { cancelable: true });
      window.dispatchEvent(event);
      return event.defaultPrevented;
    });
  expect(await asks()).toBe(true);
  await page.keyboard.press("Enter");
  await expect(status(page)).toContainText("Cancelled");
  expect(await asks()).toBe(false);
  await page.keyboard.press("Escape");
  await expect(page.getByRole("dialog", { name: "Pictures and films" })).toBeHidden();
});

test("a picture can be cancelled, and the view stays as it was", { tag: "@slow" }, async ({
  page,
}) => {
  test.setTimeout(180_000);
  await page.setViewportSize({ width: 420, height: 400 });
  await openDialog(page, "40,25,2500,63.5,63.5,63.5"); // most of the picture is background
  await page.keyboard.press("Escape");
  await settled(page);
  const before = await savedPicture(page);
  await settled(page);
  await page.getByRole("application").focus();
  await page.keyboard.press("Shift+S");
  await chooseSize(page, 16385, 16384);
  await expect(status(page)).toContainText("from 1 to 16384");
  await chooseSize(page, 6000, 6000);
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await expect(status(page)).toHaveText(/Drawing/, {
    timeout: 60_000,
  });
  // Click in one task: each part of the picture blocks the page, and a click by the pointer takes
  // several tasks.
  const cancel = page.locator(".capture-actions wa-button", { hasText: "Cancel" });
  await cancel.evaluate((button: HTMLElement) => button.click());
  await expect(status(page)).toHaveText("Cancelled", {
    timeout: 60_000,
  });
  await page.keyboard.press("Escape");
  await settled(page);
  const after = await savedPicture(page);
  expect((await compare(page, before, after)).differing).toBeLessThan(0.001);
});

test("title, scale bar, axes, legend and measurements are drawn above the picture, or beside it in SVG", async ({
  page,
}) => {
  test.setTimeout(180_000);
  const measure = "measure=distance,30,63.5,63.5,97,63.5,63.5|<wide> %26 deep";
  await openDialog(page, `${camera}&colour-by=gradient&${measure}`);
  await chooseSize(page, 480, 360);
  const plain = await save(page);
  for (const name of ["Title", "Scale bar", "Axes", "Legend", "Measurements"]) {
    await page.getByRole("checkbox", { name, exact: true }).check();
  }
  const marked = await save(page);
  await page.getByRole("combobox", { name: /^File/ }).selectOption("svg");
  const svg = (await save(page)).toString();
  if (process.env.ISOSPLAT_PICTURES) {
    writeFileSync(join(process.env.ISOSPLAT_PICTURES, "marked.png"), marked);
    writeFileSync(join(process.env.ISOSPLAT_PICTURES, "marked.svg"), svg);
  }

  // The letters and lines alone differ.
  const found = await compare(page, marked, plain);
  expect(found.differing).toBeGreaterThan(0.01);
  expect(found.differing).toBeLessThan(0.15);

  const { texts, image, error } = await page.evaluate((text) => {
    const parsed = new DOMParser().parseFromString(text, "image/svg+xml");
    return {
      error: parsed.querySelector("parsererror")?.textContent ?? null,
      texts: [...parsed.querySelectorAll("text")].map((each) => each.textContent),
      image: parsed.querySelector("image")?.getAttribute("href") ?? "",
    };
  }, svg);
  expect(error).toBeNull();
  expect(texts).toEqual(
    expect.arrayContaining([
      expect.stringMatching(/^Gradient/),
      expect.stringMatching(/ mm$/),
      expect.stringContaining("<wide> & deep"),
      "x",
      "y",
      "z",
    ]),
  );
  // The picture below is the one without marks.
  expect(Buffer.from(image.split(",")[1] ?? "", "base64").equals(plain)).toBe(true);
});

test("a picture without background is transparent", async ({ page }) => {
  test.setTimeout(120_000);
  await openDialog(page);
  await chooseSize(page, 120, 90);
  await page.getByLabel("Without background").check();
  const png = await save(page);
  // IHDR: width, height, 8 bits, RGBA.
  expect([png.readUInt32BE(16), png.readUInt32BE(20), png[24], png[25]]).toEqual([120, 90, 8, 6]);
  const corner = await page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context?.drawImage(bitmap, 0, 0);
    const alpha = (x: number, y: number) => context?.getImageData(x, y, 1, 1).data[3];
    return [alpha(0, 0), alpha(60, 20)];
  }, png.toString("base64"));
  expect(corner[0]).toBe(0);
  await expect(status(page)).toContainText("Saved");
});

/** Chooses three small frames of a film. */
async function chooseFilm(page: Page, what: string, file: string): Promise<void> {
  await page.getByLabel("What").selectOption({ label: what });
  await chooseSize(page, 65, 48);
  await page.getByLabel("Seconds").fill("0.125");
  await page.getByLabel("Frames per second").selectOption("24");
  await page.getByLabel("File").selectOption({ label: file });
}

for (const [label, type, frames] of [
  ["WebM video", "video/webm", 2], // its duration ends where the third frame begins
  ["MP4 video (H.264)", "video/mp4", 3],
] as const) {
  test(`a film once around is a ${label} of its length`, { tag: "@slow" }, async ({
    page,
    context,
  }) => {
    test.setTimeout(180_000);
    await page.setViewportSize({ width: 420, height: 400 });
    await openDialog(page);
    const address = page.url();
    await chooseFilm(page, "Film: once around", label);
    await expect(status(page)).toContainText("3 frames, at most about");
    const film = await save(page);
    // The page's content security policy does not let the page play files.
    const player = await context.newPage();
    const found = await player.evaluate(
      async ([base64, type]) => {
        const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
        const video = document.createElement("video");
        video.muted = true;
        video.src = URL.createObjectURL(new Blob([bytes], { type }));
        await new Promise((resolve, reject) => {
          video.addEventListener("loadeddata", resolve);
          video.addEventListener("error", () => reject(new Error(video.error?.message)));
        });
        video.currentTime = 0.05;
        await new Promise((resolve) => video.addEventListener("seeked", resolve));
        const context = new OffscreenCanvas(64, 48).getContext("2d");
        context?.drawImage(video, 0, 0);
        const { data } = context?.getImageData(0, 0, 64, 48) ?? { data: [] };
        const red = data.filter((_, i) => i % 4 === 0);
        const { duration, videoWidth, videoHeight } = video;
        return { duration, videoWidth, videoHeight, low: Math.min(...red), high: Math.max(...red) };
      },
      [film.toString("base64"), type] as const,
    );
    // Videos have even sizes.
    expect([found.videoWidth, found.videoHeight]).toEqual([64, 48]);
    expect(found.duration).toBeCloseTo(frames / 24, 2);
    expect(found.high - found.low).toBeGreaterThan(60);
    await player.close();
    await page.keyboard.press("Escape");
    await settled(page);
    expect(page.url()).toBe(address);
  });
}

test("a film is an animated GIF", { tag: "@slow" }, async ({ page }) => {
  test.setTimeout(180_000);
  await page.setViewportSize({ width: 420, height: 400 });
  await openDialog(page);
  await chooseFilm(page, "Film: once around", "Animated GIF");
  const gif = await save(page);
  const frames = await page.evaluate(async (base64) => {
    const data = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const decoder = new ImageDecoder({ data, type: "image/gif" });
    await decoder.tracks.ready;
    await decoder.completed;
    const { image } = await decoder.decode({ frameIndex: 1 });
    const { frameCount, repetitionCount } = decoder.tracks.selectedTrack ?? {};
    const { displayWidth, displayHeight, duration } = image;
    return { frameCount, repetitionCount, displayWidth, displayHeight, duration };
  }, gif.toString("base64"));
  expect(frames).toEqual({
    frameCount: 3,
    repetitionCount: Number.POSITIVE_INFINITY,
    displayWidth: 65,
    displayHeight: 48,
    duration: 40_000, // 24 frames per second, in hundredths of a second
  });
});

test("a film through isovalues, or from view to view, is a ZIP of pictures", {
  tag: "@slow",
}, async ({ page }) => {
  test.setTimeout(180_000);
  await page.setViewportSize({ width: 420, height: 400 });
  await openDialog(page);
  await page.keyboard.press("Escape");
  const before = await savedPicture(page);
  await page.getByRole("application").focus();
  await page.keyboard.press("Shift+S");
  await chooseFilm(page, "Film: through isovalues", "PNG files in a ZIP");
  await page.getByLabel("From isovalue").fill("60");
  await page.getByLabel("To isovalue").fill("180");
  const swept = (await save(page)).toString("latin1");
  for (const name of ["frame-0001.png", "frame-0002.png", "frame-0003.png"]) {
    expect(swept).toContain(name);
  }
  // Afterwards, the isovalue is again the one in the panel.
  await page.keyboard.press("Escape");
  await settled(page);
  expect((await compare(page, before, await savedPicture(page))).differing).toBeLessThan(0.001);
  await page.getByRole("application").focus();
  await page.keyboard.press("Shift+S");
  await chooseFilm(page, "Film: from view to view", "PNG files in a ZIP");
  await expect(status(page)).toContainText("at least two views");
  await page.getByRole("button", { name: "Add this view" }).click();
  await page.keyboard.press("Escape");
  await page.getByRole("application").focus();
  await page.keyboard.press("ArrowLeft");
  await settled(page);
  await page.keyboard.press("Shift+S");
  await page.getByRole("button", { name: "Add this view" }).click();
  await expect(status(page)).toContainText("3 frames");
  expect((await save(page)).toString("latin1")).toContain("frame-0003.png");
});
