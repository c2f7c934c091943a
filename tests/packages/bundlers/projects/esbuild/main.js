import { setAssetBase } from "isosplat/element";

// The build copies node_modules/isosplat/assets there.
setAssetBase("./dist/isosplat/");
