/**
 * The menu of the address bar is a page that Chromium loads for each new window: 1.5 s of processor time for each
 * test. The last list counts alone, so this one begins with Playwright's, as far as Chromium knows its features.
 */
const disabledFeatures = [
  "AvoidUnnecessaryBeforeUnloadCheckSync",
  "DestroyProfileOnBrowserClose",
  "HttpsUpgrades",
  "HttpsFirstBalancedModeAutoEnable",
  "LensOverlay",
  "MediaRouter",
  "PaintHolding",
  "ThirdPartyStoragePartitioning",
  "AvoidCorsURLLoaderRestartOnRedirect",
  "OptimizationHints",
  "NetworkTimeServiceQuerying",
  "AimEnabled",
  "PreconnectToSearch",
  "WebUIOmniboxPopup",
  "WebUIOmniboxAimPopup",
];

/** How browser tests and benchmarks start Debian's Chromium: WebGL is drawn by llvmpipe. */
export const launchOptions = {
  executablePath: process.env.ISOSPLAT_CHROMIUM ?? "/usr/bin/chromium",
  args: [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=gles-egl",
    "--ignore-gpu-blocklist",
    `--disable-features=${disabledFeatures.join(",")}`,
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
  ],
};
