// The functions of import_host.h: they call `files`, an option of the module's factory (ImportFiles in
// web/import/module.ts).
// biome-ignore-all lint/complexity/useArrowFunction: Emscripten 3.1.6 cannot link arrow functions
mergeInto(LibraryManager.library, {
  $isosplatFiles: {
    message: "",
    text: (at, bytes) => new TextDecoder().decode(HEAPU8.slice(at, at + bytes)),
    put: (bytes, at, limit) => HEAPU8.set(bytes.subarray(0, limit), at),
  },
  isosplat_file_find__deps: ["$isosplatFiles"],
  isosplat_file_find: function (path, bytes) {
    return Module["files"]["find"](isosplatFiles.text(path, bytes));
  },
  isosplat_file_bytes: function (file) {
    return Module["files"]["bytes"](file);
  },
  isosplat_file_modified: function (file) {
    return Module["files"]["modified"](file);
  },
  isosplat_file_read__deps: ["$isosplatFiles"],
  isosplat_file_read: function (file, offset, out, bytes) {
    try {
      return Module["files"]["read"](file, offset, HEAPU8.subarray(out, out + bytes));
    } catch (error) {
      isosplatFiles.message = error instanceof Error ? error.message : String(error);
      return -1;
    }
  },
  isosplat_file_error__deps: ["$isosplatFiles"],
  isosplat_file_error: function (text, limit) {
    const bytes = new TextEncoder().encode(isosplatFiles.message).subarray(0, limit);
    isosplatFiles.put(bytes, text, limit);
    return bytes.length;
  },
  isosplat_folder_names__deps: ["$isosplatFiles"],
  isosplat_folder_names: function (path, bytes, text, limit) {
    const names = Module["files"]["names"](isosplatFiles.text(path, bytes));
    const all = new TextEncoder().encode(names.map((name) => `${name}\0`).join(""));
    isosplatFiles.put(all, text, limit);
    return all.length;
  },
});
