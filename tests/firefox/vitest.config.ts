import { defineConfig } from "vitest/config";

/** Tests that run in Debian's Firefox: tests/firefox/*.firefox.ts. */
export default defineConfig({
  test: {
    environment: "node",
    include: ["tests/firefox/**/*.firefox.ts"],
    // Each file starts its own Firefox.
    fileParallelism: false,
    testTimeout: 60_000,
    hookTimeout: 60_000,
    // A picture may take long on a busy machine.
    retry: process.env.CI ? 1 : 0,
  },
});
