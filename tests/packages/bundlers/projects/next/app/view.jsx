"use client";

import "isosplat/react";

export default function View() {
  return <isosplat-viewer src="STORE" isovalue="100" style={{ width: 400 }} />;
}
