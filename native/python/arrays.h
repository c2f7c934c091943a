#pragma once

#include <pybind11/numpy.h>

#include <memory>
#include <utility>
#include <vector>

namespace isosplat::python {

/// A NumPy array of shape (rows.size(), columns) that owns the rows, without a copy. A row is
/// `columns` consecutive scalars. Requires the GIL.
template <class Scalar, class Row>
pybind11::array_t<Scalar> take_rows(std::vector<Row>&& rows) {
  static_assert(sizeof(Row) % sizeof(Scalar) == 0);
  constexpr auto kColumns = static_cast<pybind11::ssize_t>(sizeof(Row) / sizeof(Scalar));
  auto owned = std::make_unique<std::vector<Row>>(std::move(rows));
  const auto count = static_cast<pybind11::ssize_t>(owned->size());
  const auto* data = reinterpret_cast<const Scalar*>(owned->data());
  const pybind11::capsule owner(owned.get(),
                                [](void* p) { delete static_cast<std::vector<Row>*>(p); });
  owned.release();
  return pybind11::array_t<Scalar>({count, kColumns}, data, owner);
}

/// A NumPy array of one axis that owns the values, without a copy. Requires the GIL.
template <class Scalar>
pybind11::array_t<Scalar> take_values(std::vector<Scalar>&& values) {
  auto owned = std::make_unique<std::vector<Scalar>>(std::move(values));
  const auto count = static_cast<pybind11::ssize_t>(owned->size());
  const Scalar* data = owned->data();
  const pybind11::capsule owner(owned.get(),
                                [](void* p) { delete static_cast<std::vector<Scalar>*>(p); });
  owned.release();
  return pybind11::array_t<Scalar>(count, data, owner);
}

/// A read-only NumPy array of one axis of values that `owner` keeps.
template <class Scalar>
pybind11::array_t<Scalar> view_values(const std::vector<Scalar>& values,
                                      const pybind11::object& owner) {
  pybind11::array_t<Scalar> view(static_cast<pybind11::ssize_t>(values.size()), values.data(),
                                 owner);
  view.attr("setflags")(pybind11::arg("write") = false);
  return view;
}

/// A read-only NumPy array of shape (rows.size(), columns) of rows that `owner` keeps.
template <class Scalar, class Row>
pybind11::array_t<Scalar> view_rows(const std::vector<Row>& rows, const pybind11::object& owner) {
  constexpr auto kColumns = static_cast<pybind11::ssize_t>(sizeof(Row) / sizeof(Scalar));
  const auto count = static_cast<pybind11::ssize_t>(rows.size());
  pybind11::array_t<Scalar> view({count, kColumns}, reinterpret_cast<const Scalar*>(rows.data()),
                                 owner);
  view.attr("setflags")(pybind11::arg("write") = false);
  return view;
}

}  // namespace isosplat::python
