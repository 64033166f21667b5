#include <modsearch/problem/geometry_internal.hpp>
#include <stdexcept>

#include "reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto file = fuzz::as_file(fuzz::text(data, size), "mesh.stl");
  // The reader of the document that names the mesh makes a FileError of it.
  return fuzz::read<std::runtime_error>(
      [&] { static_cast<void>(modsearch::detail::load_mesh(file, Eigen::Vector3d::Ones())); });
}
