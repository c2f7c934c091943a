import "isosplat/element";
