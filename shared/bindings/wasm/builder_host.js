// The functions of builder_host.h: they call `host`, an option of the module's factory (BuilderHost in
// web/builder/module.ts).
// biome-ignore-all lint/complexity/useArrowFunction: Emscripten 3.1.6 cannot link arrow functions
mergeInto(LibraryManager.library, {
  $isosplatHost: {
    message: "",
    attempt: (call) => {
      try {
        call();
        return 0;
      } catch (error) {
        isosplatHost.message = error instanceof Error ? error.message : String(error);
        return 1;
      }
    },
  },
  isosplat_host_read_slices__deps: ["$isosplatHost"],
  isosplat_host_read_slices: function (first, count, out, bytes) {
    return isosplatHost.attempt(() => {
      Module["host"]["readSlices"](first, count, HEAPU8.subarray(out, out + bytes));
    });
  },
  isosplat_host_write__deps: ["$isosplatHost"],
  isosplat_host_write: function (offset, data, bytes) {
    return isosplatHost.attempt(() => {
      Module["host"]["write"](offset, HEAPU8.slice(data, data + bytes));
    });
  },
  isosplat_host_error__deps: ["$isosplatHost"],
  isosplat_host_error: function (text, limit) {
    const bytes = new TextEncoder().encode(isosplatHost.message).subarray(0, limit);
    HEAPU8.set(bytes, text);
    return bytes.length;
  },
  isosplat_host_progress: function (fraction, voxelsPerSecond, secondsLeft) {
    Module["host"]["progress"](fraction, voxelsPerSecond, secondsLeft);
  },
});
