import { defineConfig } from "vitest/config";

/**
 * Tests that run in Node: tests/web/*.spec.ts and tests/packages. Those in Chromium belong to
 * Playwright; those in Firefox have a configuration of their own (tests/firefox/vitest.config.ts).
 */
export default defineConfig({
  test: {
    environment: "node",
    include: ["tests/web/**/*.spec.ts", "tests/packages/**/*.spec.ts"],
    testTimeout: 30_000,
    // Tests of faults wait for real servers, which other work may hold up.
    retry: 2,
    passWithNoTests: true,
    // A thumbnail takes longer than building a small volume.
    env: { ISOSPLAT_NO_THUMBNAIL: "1" },
  },
});
