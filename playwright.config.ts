import { defineConfig } from "@playwright/test";
import { launchOptions } from "./tests/browser/support/chromium.ts";

/**
 * Tests that run in Debian's Chromium: tests/browser/*.browser.ts and tests/packages. Each starts the real server on a
 * free port. WebGL is drawn by llvmpipe, which gives the pixels of native EGL; Chromium falls back
 * to another renderer silently, so picture tests assert UNMASKED_RENDERER_WEBGL.
 */
export default defineConfig({
  testDir: "tests",
  testMatch: ["browser/**/*.browser.ts", "packages/**/*.browser.ts"],
  outputDir: "build/test-results/browser",
  workers: 1,
  fullyParallel: false,
  forbidOnly: Boolean(process.env.CI),
  // A picture may come late on a machine that does other things beside; what passes only then is
  // reported as flaky.
  retries: process.env.CI ? 1 : 0,
  timeout: 60_000,
  expect: { timeout: 20_000 },
  reporter: [["list"], ["json", { outputFile: "build/test-results/browser.json" }]],
  use: {
    browserName: "chromium",
    trace: "retain-on-failure",
    screenshot: "only-on-failure",
    // A click cannot miss what does not move.
    contextOptions: { reducedMotion: "reduce" },
    launchOptions,
  },
});
