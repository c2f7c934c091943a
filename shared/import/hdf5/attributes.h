#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/import/axes/array_attributes.h"
#include "shared/import/hdf5/type.h"

namespace isosplat::import {

/// The numbers of an attribute. Nothing if it does not exist, is not numeric, or has more numbers
/// than are useful here.
std::optional<std::vector<double>> hdf5_numbers(const Hdf5File& file, const Hdf5Object& object,
                                                std::string_view name);

/// The texts of an attribute, without padding. Nothing if it does not exist, does not contain
/// texts, has more than are useful here, or is damaged.
std::optional<std::vector<std::string>> hdf5_texts(Hdf5File& file, const Hdf5Object& object,
                                                   std::string_view name);

/// The text of an attribute. Joins the texts of an array, since Imaris stores each character as one
/// text. Empty where hdf5_texts() returns nothing.
std::string hdf5_text(Hdf5File& file, const Hdf5Object& object, std::string_view name);

/// The addresses of the headers of objects that an attribute refers to, in lists (HDF5's dimension
/// scales). Nothing if it does not exist, is of another type, or is damaged.
std::optional<std::vector<std::vector<uint64_t>>> hdf5_references(Hdf5File& file,
                                                                  const Hdf5Object& object,
                                                                  std::string_view name);

/// The type of an attribute's numbers. Nothing where hdf5_numbers() returns nothing.
std::optional<VoxelType> hdf5_number_type(const Hdf5File& file, const Hdf5Object& object,
                                          std::string_view name);

/// Those of an object of a file, both of which must outlive it.
class Hdf5Attributes : public ArrayAttributes {
 public:
  Hdf5Attributes(Hdf5File& file, const Hdf5Object& object) : file_(file), object_(object) {}

  std::optional<std::vector<double>> numbers(std::string_view name) const override {
    return hdf5_numbers(file_, object_, name);
  }
  std::optional<VoxelType> number_type(std::string_view name) const override {
    return hdf5_number_type(file_, object_, name);
  }
  std::string text(std::string_view name) const override { return hdf5_text(file_, object_, name); }

 private:
  Hdf5File& file_;
  const Hdf5Object& object_;
};

}  // namespace isosplat::import
