#include "holdfast/mesh.hpp"

#include <nanobind/stl/filesystem.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "holdfast/io.hpp"
#include "texture_argument.hpp"
#include "values.hpp"

namespace holdfast {

inline auto fields_of(const Texture* /*texture*/) {
  return std::tuple(&Texture::width, &Texture::height, &Texture::rgba);
}
inline auto fields_of(const Material* /*material*/) { return std::tuple(&Material::name, &Material::texture); }

inline bool is_sound(const Texture& texture) {
  return texture.width >= 0 && texture.height >= 0 &&
         texture.rgba.size() == 4 * static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height);
}
inline bool is_sound(const Mesh& mesh) {
  mesh.validate();
  return true;
}

}  // namespace holdfast

namespace holdfast::python {

Texture texture_argument(nb::handle value, const char* name) {
  if (nb::isinstance<nb::str>(value) || nb::hasattr(value, "__fspath__")) {
    throw nb::type_error((std::string(name) + ": expected a numpy array of uint8, RGB, got " + described(value) +
                          "; numpy.asarray(PIL.Image.open(file)) reads one, Mesh.load() a model with its textures")
                             .c_str());
  }
  const bool of_pillow = nb::hasattr(value, "convert") && nb::hasattr(value, "mode");
  const nb::object array =
      of_pillow ? nb::module_::import_("numpy").attr("asarray")(value.attr("convert")("RGBA")) : nb::borrow(value);
  const FrameArgument image =
      frame_argument(array, name, std::nullopt, "pass numpy.ascontiguousarray of it (a model's image is RGB)");
  const int channels = image.view.format == PixelFormat::rgba8 ? 4 : image.view.format == PixelFormat::bgr8 ? 3 : 1;
  Texture texture{image.view.width, image.view.height, {}};
  texture.rgba.reserve(static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height) * 4);
  for (int y = 0; y < texture.height; ++y) {
    const std::uint8_t* pixel = image.view.data + static_cast<std::size_t>(y) * image.view.stride_bytes;
    for (int x = 0; x < texture.width; ++x, pixel += channels) {
      const bool grey = channels == 1;
      const std::uint8_t alpha = channels == 4 ? pixel[3] : 255;
      texture.rgba.insert(texture.rgba.end(), {pixel[0], pixel[grey ? 0 : 1], pixel[grey ? 0 : 2], alpha});
    }
  }
  return texture;
}

namespace {

std::uint32_t vertex_index(double value) {
  if (!(value >= 0 && value < 4294967296.0) || value != std::floor(value)) {
    throw nb::value_error("faces: vertex indices must be whole numbers of 0 or more");
  }
  return static_cast<std::uint32_t>(value);
}

std::array<std::uint8_t, 4> color_of(const double* channels, int count) {
  std::array<std::uint8_t, 4> color{255, 255, 255, 255};
  for (int i = 0; i < count; ++i) {
    if (!(channels[i] >= 0 && channels[i] <= 255)) throw nb::value_error("colors: values must be 0 to 255");
    color[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(channels[i]);
  }
  return color;
}

Mesh mesh_of_arrays(nb::object vertices, nb::object faces, nb::object uv, nb::object image, nb::object colors) {
  Mesh mesh;
  const std::vector<double> v = numbers_argument(vertices, "vertices", -1, 3);
  for (std::size_t i = 0; i < v.size(); i += 3) {
    mesh.positions.emplace_back(Eigen::Vector3d(v[i], v[i + 1], v[i + 2]).cast<float>());
  }
  const std::vector<double> f = numbers_argument(faces, "faces", -1, 3);
  for (std::size_t i = 0; i < f.size(); i += 3) {
    mesh.triangles.push_back({vertex_index(f[i]), vertex_index(f[i + 1]), vertex_index(f[i + 2])});
  }
  const auto rows = static_cast<int>(mesh.positions.size());
  if (!uv.is_none()) {
    const std::vector<double> t = numbers_argument(uv, "uv", rows, 2);
    for (std::size_t i = 0; i < t.size(); i += 2) {
      mesh.texture_coordinates.emplace_back(static_cast<float>(t[i]), static_cast<float>(t[i + 1]));
    }
  }
  if (!image.is_none()) mesh.materials.push_back({"image", texture_argument(image, "image")});
  if (!colors.is_none()) {
    const std::vector<double> c = numbers_argument(colors, "colors", rows, -1);
    const int channels = rows > 0 ? static_cast<int>(c.size() / static_cast<std::size_t>(rows)) : 0;
    if (channels != 3 && channels != 4) {
      throw nb::value_error(("colors: expected shape (N, 3) or (N, 4), got " + described(colors)).c_str());
    }
    for (const double* row = c.data(); row != c.data() + c.size(); row += channels) {
      mesh.colors.push_back(color_of(row, channels));
    }
  }
  mesh.validate();
  return mesh;
}

/// All rows of a vector of fixed-size rows, as an array of its own.
template <class T, int Columns, class Rows>
auto rows_array(const Rows& rows) {
  std::vector<T> values;
  values.reserve(rows.size() * Columns);
  for (const auto& row : rows) {
    for (int i = 0; i < Columns; ++i) values.push_back(row[static_cast<std::size_t>(i)]);
  }
  return owned_array<Numpy<T, nb::shape<-1, Columns>>>(std::move(values), {rows.size(), Columns});
}

nb::list images_of(const Mesh& mesh) {
  nb::list images;
  for (const Material& material : mesh.materials) {
    const Texture& texture = material.texture;
    if (texture.empty()) {
      images.append(nb::none());
      continue;
    }
    images.append(owned_array<Numpy<std::uint8_t, nb::shape<-1, -1, 4>>>(
        texture.rgba, {static_cast<std::size_t>(texture.height), static_cast<std::size_t>(texture.width), 4}));
  }
  return images;
}

}  // namespace

void bind_mesh(nb::module_& module) {
  nb::class_<Mesh> mesh_class(module, "Mesh", nb::type_slots(kCheckedCalls),
                              "Triangle mesh in metres, in the object's frame, with textures or vertex colours.");
  make_value(mesh_class, &Mesh::positions, &Mesh::texture_coordinates, &Mesh::colors, &Mesh::triangles,
             &Mesh::triangle_materials, &Mesh::materials);
  mesh_class
      .def(
          "__init__",
          [](Mesh* self, nb::object vertices, nb::object faces, nb::object uv, nb::object image, nb::object colors) {
            new (self) Mesh(mesh_of_arrays(vertices, faces, uv, image, colors));
          },
          nb::arg("vertices"), nb::arg("faces"), nb::arg("uv") = nb::none(), nb::arg("image") = nb::none(),
          nb::arg("colors") = nb::none(),
          nb::sig("def __init__(self, vertices: numpy.typing.ArrayLike, faces: numpy.typing.ArrayLike, uv: "
                  "numpy.typing.ArrayLike | None = None, image: numpy.typing.NDArray[numpy.uint8] | None = None, "
                  "colors: numpy.typing.ArrayLike | None = None) -> None"),
          "vertices: Nx3, metres. faces: Mx3 vertex indices. uv: Nx2, v upwards. image: HxWx3 RGB, HxWx4 RGBA or HxW "
          "uint8, or a picture of Pillow's; rows from the top (v = 1) down; alpha below 250 marks surface of unknown "
          "look. uv without image: a model without texture, whose coordinates TextureBaker uses. colors: Nx3 or Nx4, 0 "
          "to 255.")
      .def_static(
          "load",
          [](const std::filesystem::path& path, double scale) {
            std::vector<std::string> remarks;
            std::optional<Mesh> mesh;
            {
              const nb::gil_scoped_release unlocked;
              mesh = io::load_model(path, scale, &remarks);
            }
            for (const std::string& remark : remarks) {
              if (PyErr_WarnEx(PyExc_UserWarning, remark.c_str(), kCaller) != 0) throw nb::python_error();
            }
            return *std::move(mesh);
          },
          nb::arg("path"), nb::arg("scale") = 1.0,
          "Reads OBJ, PLY, glTF and all else that assimp reads. `scale` turns the file's unit into metres: 0.001 for "
          "millimetres. Warns of what the file has that is not supported.")
      .def(
          "save", [](const Mesh& mesh, const std::filesystem::path& path) { io::save_model(path, mesh); },
          nb::arg("path"), "Writes an OBJ, an MTL and a PNG for each texture, side by side.")
      .def_prop_ro(
          "vertices", [](const Mesh& mesh) { return rows_array<float, 3>(mesh.positions); }, "Nx3, metres.", kNewArray)
      .def_prop_ro(
          "faces", [](const Mesh& mesh) { return rows_array<std::uint32_t, 3>(mesh.triangles); }, "Mx3 vertex indices.",
          kNewArray)
      .def_prop_ro(
          "uv", [](const Mesh& mesh) { return rows_array<float, 2>(mesh.texture_coordinates); },
          "Nx2, v upwards; 0x2 where there are none.", kNewArray)
      .def_prop_ro(
          "colors", [](const Mesh& mesh) { return rows_array<std::uint8_t, 4>(mesh.colors); },
          "Nx4 RGBA; 0x4 where there are none.", kNewArray)
      .def_prop_ro("images", &images_of, nb::sig("def images(self) -> list[numpy.typing.NDArray[numpy.uint8] | None]"),
                   "Texture of each material, HxWx4 RGBA, or None.", kNewArray)
      .def_prop_ro(
          "center", [](const Mesh& mesh) { return matrix_array<Numpy<double>>(mesh.center().transpose().eval()); },
          "Centre of the bounding box, 1x3, metres.", kNewArray)
      .def_prop_ro("radius", &Mesh::radius, "Largest distance of a vertex from the centre, metres.")
      .def_prop_ro("has_appearance", &Mesh::has_appearance, "Whether any face has a texture or colours.")
      .def("__repr__", [](const Mesh& mesh) {
        return "<holdfast.Mesh of " + std::to_string(mesh.positions.size()) + " vertices, " +
               std::to_string(mesh.triangles.size()) + " faces>";
      });
}

}  // namespace holdfast::python
