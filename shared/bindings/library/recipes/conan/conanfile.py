"""The C++ libraries as a Conan 2 package, from the clone that contains this file:

    conan create CLONE/shared/bindings/library/recipes/conan
"""

import json
import os

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy


class IsosplatConan(ConanFile):
    name = "isosplat"
    description = "Reads isosurfaces from Isosplat's stores"
    license = "Apache-2.0"
    settings = "os", "compiler", "build_type", "arch"
    package_type = "static-library"

    @property
    def _clone(self):
        return os.path.join(self.recipe_folder, "..", "..", "..", "..", "..")

    def set_version(self):
        with open(os.path.join(self._clone, "package.json"), encoding="utf-8") as file:
            self.version = json.load(file)["version"]

    def export_sources(self):
        for pattern in ("CMakeLists.txt", "package.json", "LICENSE", "shared/*"):
            copy(self, pattern, self._clone, self.export_sources_folder)

    def requirements(self):
        self.requires("tl-expected/[>=1.0 <2]", transitive_headers=True)
        self.requires("xxhash/[>=0.8 <1]", visible=False)

    def layout(self):
        cmake_layout(self)

    def generate(self):
        CMakeDeps(self).generate()
        toolchain = CMakeToolchain(self)
        for option in ("PROGRAM", "TESTS", "WARNINGS", "CCACHE"):
            toolchain.cache_variables[f"ISOSPLAT_{option}"] = False
        toolchain.cache_variables["ISOSPLAT_ARCH"] = ""
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))
        CMake(self).install()

    def package_info(self):
        self.cpp_info.set_property("cmake_file_name", "isosplat")
        core = self.cpp_info.components["core"]
        core.libs = ["isosplat_core"]
        core.requires = ["tl-expected::tl-expected"]
        core.set_property("cmake_target_name", "isosplat::core")
        store_file = self.cpp_info.components["store_file"]
        store_file.libs = ["isosplat_store_file"]
        store_file.requires = ["core"]
        store_file.system_libs = ["pthread"]
        store_file.set_property("cmake_target_name", "isosplat::store_file")
