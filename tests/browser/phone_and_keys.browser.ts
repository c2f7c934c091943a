// The page in a phone's window, by touch and by keyboard, and in both themes.
import { expect, type Page, test } from "@playwright/test";
import { saveData, slideTo } from "./support/in_page.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { complete, openSection, settled } from "./support/view.ts";

let server: RunningServer;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
});
test.afterAll(() => server.stop());

const cameraOf = async (page: Page) => {
  await settled(page);
  const text = new URL(page.url()).searchParams.get("camera") ?? "";
  return text.split(",").map(Number);
};

test.describe("a phone", () => {
  test.use({ viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });

  test("shows picture and slider, and the rest in a sheet", async ({ page }) => {
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await complete(page);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    expect(wide).toBeLessThanOrEqual(390);
    const stage = await page.locator(".stage").boundingBox();
    expect(stage?.height).toBeGreaterThan(400);
    await expect(page.locator(".isovalue-slider")).toBeInViewport();
    await expect(page.locator(".surface")).toBeHidden();
    const more = page.getByRole("button", { name: "More controls" });
    await expect(more).toHaveAttribute("aria-expanded", "false");
    await more.tap();
    await expect(page.locator(".surface")).toBeVisible();
    const panel = page.locator(".panel");
    expect(await panel.evaluate((element) => element.scrollWidth - element.clientWidth)).toBe(0);
    await page.getByRole("button", { name: "Fewer controls" }).tap();
    await expect(page.locator(".surface")).toBeHidden();
    await more.tap();
    await page.keyboard.press("Escape");
    await expect(page.locator(".surface")).toBeHidden();
    await expect(more).toBeFocused();
  });

  test("ends of the axes can be hit by a finger", async ({ page }) => {
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await settled(page);
    await expect(page.locator(".overlay-axis")).toHaveCount(6);
    const sizes = await page
      .locator(".overlay-axis .area")
      .evaluateAll((areas) => areas.map((area) => area.getBoundingClientRect().width));
    expect(sizes).toHaveLength(6);
    expect(Math.min(...sizes)).toBeGreaterThanOrEqual(24);
  });

  test("the legend is below the status line, also where this has two lines", async ({ page }) => {
    await page.setViewportSize({ width: 320, height: 640 });
    await page.goto(
      `${server.url}?volume=bucky&isovalue=100&slices=,0.5,&clip=0,1,0,0.5,0,1&lang=de`,
    );
    await settled(page);
    const line = 30;
    const boxOf = async (part: string) =>
      (await page.locator(part).boundingBox()) ?? { y: 0, height: 0 };
    const [status, legend] = [await boxOf(".status"), await boxOf(".legend")];
    expect(status.height).toBeGreaterThan(line);
    expect(legend.y).toBeGreaterThan(status.y + status.height);
  });

  test("at 320 px the text of the state is completely visible", async ({ page }) => {
    await page.setViewportSize({ width: 320, height: 640 });
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    // The longest text, which is shown for a moment, and the final one.
    for (const text of ["preparing other isovalues", "complete"]) {
      const visible = await page.waitForFunction((text) => {
        const status = document.querySelector(".status");
        const state = document.querySelector(".status-state");
        if (!status || !state?.textContent?.includes(text)) return undefined;
        const [outer, inner] = [status.getBoundingClientRect(), state.getBoundingClientRect()];
        const isInside = inner.right < outer.right && inner.bottom < outer.bottom;
        return { isInside, right: outer.right, cut: state.scrollWidth - state.clientWidth };
      }, text);
      const { isInside, right, cut } = (await visible.jsonValue()) ?? { right: 0 };
      expect(isInside).toBe(true);
      expect(right).toBeLessThanOrEqual(320);
      expect(cut).toBeLessThanOrEqual(0);
      if (text !== "complete") await complete(page);
    }
  });

  test("at 320 px a banner leaves the picture visible", async ({ page }) => {
    await page.setViewportSize({ width: 320, height: 640 });
    await page.addInitScript(saveData);
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await complete(page);
    await page.route(/\/v1\//, (route) => route.fulfill({ status: 503 }));
    await page.evaluate(slideTo, 200);
    const banner = page.locator(".banner");
    await expect(banner).toContainText("The server answers with an error");
    const again = banner.getByRole("button", { name: "Try again" });
    const [box, button] = [await banner.boundingBox(), await again.boundingBox()];
    const view = await page.locator("canvas.view").boundingBox();
    if (!box || !button || !view) throw new Error("not shown");
    expect(box.height).toBeLessThan(0.5 * view.height);
    expect(button.x + button.width).toBeLessThanOrEqual(box.x + box.width);
    expect(box.x + box.width).toBeLessThanOrEqual(320);
  });

  test("a finger drags a face of the clip box, and the view stays", async ({ page }) => {
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await complete(page);
    await page.getByRole("button", { name: "More controls" }).tap();
    await openSection(page, "Clipping");
    await page.getByRole("button", { name: "Fewer controls" }).tap();
    // Without the sheet, the picture is larger. The handles move in the frame after its layout.
    await page.evaluate(async () => {
      for (let frame = 0; frame < 3; ++frame) await new Promise(requestAnimationFrame);
    });
    await settled(page);
    const face = page.getByRole("slider", { name: "Upper y face" });
    const box = await face.boundingBox();
    const other = await page.getByRole("slider", { name: "Lower y face" }).boundingBox();
    if (!box || !other) throw new Error("not shown");
    // Use the size in CSS pixels, because the box on the screen is rounded with its position.
    const size = await face.evaluate((e: HTMLElement) => Math.min(e.offsetWidth, e.offsetHeight));
    expect(size).toBeGreaterThanOrEqual(44);
    const touch = await page.context().newCDPSession(page);
    for (const [type, share] of [
      ["touchStart", 0],
      ["touchMove", 0.15],
      ["touchMove", 0.3],
      ["touchEnd", 0.3],
    ] as const) {
      const x = box.x + box.width / 2 + share * (other.x - box.x);
      const y = box.y + box.height / 2 + share * (other.y - box.y);
      const touchPoints = type === "touchEnd" ? [] : [{ x, y, id: 0 }];
      await touch.send("Input.dispatchTouchEvent", { type, touchPoints });
    }
    await settled(page);
    const { searchParams } = new URL(page.url());
    const [low, high, ...others] = searchParams.get("clip")?.split(",").map(Number) ?? [];
    const [yLow, yHigh = 1, ...z] = others;
    expect([low, high, yLow, ...z]).toEqual([0, 1, 0, 0, 1]);
    expect(yHigh).toBeGreaterThan(0.5);
    expect(yHigh).toBeLessThan(0.85);
    expect(searchParams.has("camera")).toBe(false);
  });

  test("one finger rotates, two pinch and pan", async ({ page }) => {
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await complete(page);
    const touch = await page.context().newCDPSession(page);
    const gesture = async (steps: [number, number][][]) => {
      for (const [i, points] of steps.entries()) {
        const touchPoints = points.map(([x, y], id) => ({ x, y, id }));
        await touch.send("Input.dispatchTouchEvent", {
          type: i === 0 ? "touchStart" : "touchMove",
          touchPoints,
        });
      }
      await touch.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
    };
    await gesture([[[150, 300]], [[190, 310]], [[230, 320]]]);
    const turned = await cameraOf(page);
    expect(turned).toHaveLength(6);
    await gesture([
      [
        [180, 300],
        [210, 300],
      ],
      [
        [160, 300],
        [230, 300],
      ],
      [
        [140, 300],
        [250, 300],
      ],
    ]);
    const pinched = await cameraOf(page);
    expect(pinched[2]).toBeLessThan(0.6 * (turned[2] ?? 0));
    expect(pinched[0]).toBeCloseTo(turned[0] ?? 0, 3);
    await gesture([
      [
        [150, 300],
        [230, 300],
      ],
      [
        [150, 340],
        [230, 340],
      ],
    ]);
    const moved = await cameraOf(page);
    expect(moved[2]).toBeCloseTo(pinched[2] ?? 0, 0);
    expect(moved.slice(3)).not.toEqual(pinched.slice(3));
  });

  test("lists volumes without scrolling sideways", async ({ page }) => {
    await page.goto(server.url);
    await expect(page.locator("a.card").first()).toBeVisible();
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    expect(wide).toBeLessThanOrEqual(390);
  });
});

test.describe("a desktop window at 200 %", () => {
  test.use({ viewport: { width: 640, height: 400 }, deviceScaleFactor: 2 });

  test("leaves the picture most of the height", async ({ page }) => {
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await complete(page);
    const stage = await page.locator(".stage").boundingBox();
    expect(stage?.height).toBeGreaterThan(300);
    expect(stage?.width).toBeGreaterThan(300);
    await expect(page.locator(".isovalue-slider")).toBeInViewport();
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    expect(wide).toBeLessThanOrEqual(640);
  });
});

test.describe("a desk", () => {
  test.use({ viewport: { width: 1000, height: 640 } });

  test("the canvas follows a change of the pixel ratio", async ({ page }) => {
    // Chromium emulates the ratio, but not the event that occurs when a window moves to another
    // screen.
    await page.addInitScript(() => {
      const original = window.matchMedia.bind(window);
      window.matchMedia = (query) => {
        const list = original(query);
        if (query.includes("resolution")) {
          window.addEventListener("other-screen", () => list.dispatchEvent(new Event("change")));
        }
        return list;
      };
    });
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await complete(page);
    const widths = () =>
      page.evaluate(() =>
        [...document.querySelectorAll<HTMLCanvasElement>("#view, .histogram-bars")].map(
          (canvas) => canvas.width / canvas.clientWidth,
        ),
      );
    // The widths of the picture and of the histogram.
    expect(await widths()).toHaveLength(2);
    for (const ratio of await widths()) expect(ratio).toBeCloseTo(1, 1);
    const screen = await page.context().newCDPSession(page);
    await screen.send("Emulation.setDeviceMetricsOverride", {
      width: 1000,
      height: 640,
      deviceScaleFactor: 2,
      mobile: false,
    });
    await page.evaluate(() => window.dispatchEvent(new Event("other-screen")));
    await expect
      .poll(async () => Math.min(...(await widths())), { timeout: 20_000 })
      .toBeGreaterThan(1.9);
  });

  test("letter keys work with Caps Lock", async ({ page }) => {
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await complete(page);
    const panel = page.locator(".panel");
    const capital = (key: string) =>
      page.evaluate((letter) => {
        window.dispatchEvent(new KeyboardEvent("keydown", { key: letter, bubbles: true }));
      }, key);
    await capital("F");
    await expect(panel).toBeHidden();
    await capital("F");
    await expect(panel).toBeVisible();
  });

  test("the focus stays in the list when a surface is removed", async ({ page }) => {
    await page.goto(`${server.url}?volume=bucky&isovalue=60,100,140`);
    await complete(page);
    await page.waitForFunction(() => !document.querySelector(":not(:defined)"));
    for (const left of [2, 1]) {
      await page.getByRole("button", { name: `Remove surface ${left + 1}` }).press("Enter");
      await expect(page.locator(".surface")).toHaveCount(left);
      await expect(page.locator(".surface-value").nth(left - 1)).toBeFocused();
    }
  });

  test("colour maps have a legend", async ({ page }) => {
    await page.goto(`${server.url}?volume=bucky&isovalue=100&colour-by=isovalue&map=magma`);
    await complete(page);
    const legend = page.locator(".legend");
    await expect(legend).toContainText("Isovalue");
    await expect(legend.locator(".legend-ends")).toHaveText(/0\s*247/);
    const colours = await legend.locator(".legend-colours").getAttribute("style");
    expect(colours).toMatch(/rgb\(0 0 4\).*rgb\(252 253 191\)/);
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await complete(page);
    await expect(legend).toHaveCount(0);
  });

  test("a view at rest shows no frame rate", async ({ page }) => {
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await complete(page);
    await page.keyboard.press("ArrowLeft");
    await settled(page);
    await expect(page.locator(".status-frames")).toHaveText("");
  });

  test("tools stand above the look; an opened section is in view", async ({ page }) => {
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await complete(page);
    const sections = page.locator(".panel wa-details");
    expect(
      await sections.evaluateAll((all) => all.map((each) => each.getAttribute("summary"))),
    ).toEqual([
      "Layers",
      "Measure",
      "Clipping",
      "Slices",
      "Appearance",
      "Light",
      "View",
      "About this volume",
    ]);
    // Their contents are loaded when they are opened.
    for (const [name, last] of [
      ["Measure", page.getByRole("button", { name: "Save session" })],
      ["Slices", page.locator("wa-details[summary=Slices] button").last()],
    ] as const) {
      await page.getByRole("button", { name, exact: true }).click();
      await expect(last).toBeInViewport();
    }
  });

  test("all controls have names and can be reached by keyboard", async ({ page }) => {
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await complete(page);
    await page.waitForFunction(() => !document.querySelector(":not(:defined)"));
    const names: string[] = [];
    for (let i = 0; i < 24; ++i) {
      await page.keyboard.press("Tab");
      names.push(
        await page.evaluate(() => {
          const host = document.activeElement;
          const inner = host?.shadowRoot?.activeElement ?? host;
          const label = (element: Element | null | undefined) => {
            const id = element?.getAttribute("aria-labelledby") ?? "";
            const root = element?.getRootNode() as Document | ShadowRoot | undefined;
            const by =
              (element as HTMLInputElement | null)?.labels?.[0] ?? root?.getElementById(id);
            const attribute = element?.getAttribute("aria-label") ?? element?.getAttribute("label");
            return attribute || by?.textContent?.trim() || element?.getAttribute("title") || "";
          };
          return label(inner) || label(host) || (host?.textContent ?? "").trim();
        }),
      );
    }
    const all = names.join("|");
    for (const name of [
      "Save a picture",
      "Copy a link",
      "Isosurface of",
      "Isovalue",
      "Add a surface",
    ]) {
      expect(all).toContain(name);
    }
    expect(names.slice(0, 12).filter((name) => name === "")).toEqual([]);
  });

  test("help opens with ? and closes with Escape; keys do nothing behind it", async ({ page }) => {
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await complete(page);
    await page.keyboard.press("?");
    await expect(page.getByRole("dialog", { name: "Keys and gestures" })).toBeVisible();
    await page.keyboard.press("]");
    await page.keyboard.press("Escape");
    await expect(page.getByRole("dialog")).toBeHidden();
    await expect(page).toHaveURL(/isovalue=100(&|$)/);
    await page.keyboard.press("]");
    await expect(page).toHaveURL(/isovalue=102.5/);
    // As on keyboards that have brackets with Option, or with AltGr, which is Control and Alt.
    const withModifiers = (keys: { key: string; altKey: boolean; ctrlKey?: boolean }) =>
      page.evaluate((init) => {
        document.body.dispatchEvent(new KeyboardEvent("keydown", { bubbles: true, ...init }));
      }, keys);
    await withModifiers({ key: "[", altKey: true });
    await expect(page).toHaveURL(/isovalue=100(&|$)/);
    await withModifiers({ key: "]", altKey: true, ctrlKey: true });
    await expect(page).toHaveURL(/isovalue=102.5/);
  });

  test("a typed isovalue is used exactly; invalid text is ignored", async ({ page }) => {
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await complete(page);
    const field = page.locator(".isovalue-field");
    await field.fill("77.25");
    await field.press("Enter");
    await expect(page).toHaveURL(/isovalue=77.25/);
    await field.fill("60,5");
    await field.press("Enter");
    await expect(page).toHaveURL(/isovalue=60.5/);
    await field.fill("77,25");
    await field.press("Enter");
    await expect(page).toHaveURL(/isovalue=77.25/);
    await field.fill("");
    await field.press("Enter");
    await expect(field).toHaveValue("77.25");
    await field.fill("100000");
    await field.press("Enter");
    await expect(page).toHaveURL(/isovalue=247/);
  });

  test("page keys and undo work while the slider has the focus", async ({ page }) => {
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await complete(page);
    const slider = page.locator(".isovalue-slider");
    await slider.press("ArrowRight");
    await expect(page).toHaveURL(/isovalue=100.5/);
    await expect(slider).toBeFocused();
    await page.keyboard.press("Control+z");
    await expect(page).toHaveURL(/isovalue=100(&|$)/);
    await page.keyboard.press("]");
    await expect(page).toHaveURL(/isovalue=102.5/);
    // Typed text stays, although a sweep was moving the isovalue.
    await page.getByRole("button", { name: "Sweep" }).click();
    const field = page.locator(".isovalue-field");
    await field.fill("77");
    await page.waitForTimeout(300);
    await expect(field).toHaveValue("77");
    await field.press("Enter");
    await expect(page).toHaveURL(/isovalue=77(&|$)/);
  });

  test("the label of the theme button states its effect, also on the page of a volume", async ({
    page,
  }) => {
    await page.emulateMedia({ colorScheme: "light" });
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await page.getByRole("button", { name: "Dark theme" }).click();
    await expect(page.locator("html")).toHaveClass(/wa-dark/);
    await page.getByRole("button", { name: "Light theme" }).click();
    await expect(page.locator("html")).toHaveClass(/wa-light/);
  });

  test("copies a link to the view", async ({ page, context }) => {
    await context.grantPermissions(["clipboard-read", "clipboard-write"]);
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await complete(page);
    await page.getByRole("button", { name: "Copy a link to this view" }).click();
    await expect(page.locator(".toast")).toHaveText(/Link copied/);
    expect(await page.evaluate(() => navigator.clipboard.readText())).toBe(page.url());
  });

  test("follows the system's theme until the visitor chooses", async ({ page }) => {
    await page.emulateMedia({ colorScheme: "dark" });
    await page.goto(server.url);
    await expect(page.locator("html")).toHaveClass(/wa-dark/);
    await page.getByRole("button", { name: "Light theme" }).click();
    await expect(page.locator("html")).toHaveClass(/wa-light/);
    await page.reload();
    await expect(page.locator("html")).toHaveClass(/wa-light/);
    await expect(page.locator("html")).not.toHaveClass(/wa-dark/);
  });
});

test("ends of the clip box have names and positions in the page's language, and can be hit", async ({
  page,
}) => {
  await page.goto(`${server.url}?volume=bucky&isovalue=100&lang=de`);
  await settled(page);
  await openSection(page, "Schnitt");
  const from = page.getByRole("slider", { name: /^x.*: von$/ });
  const to = page.getByRole("slider", { name: /^x.*: bis$/ });
  await expect(from).toHaveAttribute("aria-valuetext", /^0/);
  await expect(to).toHaveAttribute("aria-valuetext", /^127/);
  // The box keeps a hundredth of the volume.
  await from.focus();
  await page.keyboard.press("End");
  const text = page.locator(".with-value", { has: from }).locator(".slider-value");
  await expect(text).toHaveText(/^125[,.]7/);
  await expect(from).toHaveAttribute("aria-valuetext", /^125[,.]7/);
  const box = await to.boundingBox();
  expect(Math.min(box?.width ?? 0, box?.height ?? 0)).toBeGreaterThanOrEqual(24);
});
