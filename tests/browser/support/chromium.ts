/** How browser tests and benchmarks start Debian's Chromium: WebGL is drawn by llvmpipe. */
export const launchOptions = {
  executablePath: process.env.ISOSPLAT_CHROMIUM ?? "/usr/bin/chromium",
  args: [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=gles-egl",
    "--ignore-gpu-blocklist",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
  ],
};
