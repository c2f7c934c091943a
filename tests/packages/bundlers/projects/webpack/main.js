import "isosplat";
