import { defineConfig } from "@playwright/test";
import { launchOptions } from "./tests/browser/support/chromium.ts";

/** Most of their time passes until a fault ends: `npm test` runs them beside other tests. */
const faults = /(chaos|errors|faults)\.browser\.ts$/;

// A thumbnail takes longer than building a small volume.
process.env.ISOSPLAT_NO_THUMBNAIL = "1";

/**
 * Tests in Debian's Chromium: tests/browser/*.browser.ts and tests/packages. Each starts the real
 * server on a free port. llvmpipe draws WebGL, with the same pixels as native EGL. Chromium may silently
 * choose another renderer, so picture tests check UNMASKED_RENDERER_WEBGL.
 */
export default defineConfig({
  testDir: "tests",
  projects: [
    { name: "pages", testMatch: /\.browser\.ts$/, testIgnore: faults },
    { name: "faults", testMatch: faults },
  ],
  outputDir: "build/test-results/chromium",
  workers: 1,
  fullyParallel: false,
  forbidOnly: Boolean(process.env.CI),
  // Pictures may be late on a busy machine. A test that passes only the second time is reported as
  // flaky.
  retries: process.env.CI ? 1 : 0,
  timeout: 60_000,
  expect: { timeout: 20_000 },
  reporter: "list",
  use: {
    browserName: "chromium",
    // Recording each test would take a tenth of its time.
    trace: "on-first-retry",
    // A software renderer's time grows with the picture.
    viewport: { width: 960, height: 600 },
    screenshot: "only-on-failure",
    // No animations, so that clicks do not miss moving elements.
    contextOptions: { reducedMotion: "reduce" },
    // Requests of service workers pass page.route: tests/browser/offline.browser.ts allows them.
    serviceWorkers: "block",
    launchOptions,
  },
});
