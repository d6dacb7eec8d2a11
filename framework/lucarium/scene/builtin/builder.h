// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "lucarium/scene/look_at.h"
#include "lucarium/scene/scene.h"

namespace lucarium {

/// Collects flat-shaded or smooth triangles of one mesh. Faces are counter-clockwise seen from their front.
class MeshBuilder {
 public:
  explicit MeshBuilder(std::string name) { mesh_.name = std::move(name); }

  /// Flat faces: own vertices, the face's normal. Triangles without area are left out (quads that taper to a point).
  MeshBuilder& triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c);
  MeshBuilder& quad(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d);
  /// Axis-aligned box, all six faces outwards.
  MeshBuilder& box(const glm::vec3& min, const glm::vec3& max);
  /// One face of that box, the axis' low (side 0) or high (side 1) one, facing outwards or inwards.
  MeshBuilder& box_face(const glm::vec3& min, const glm::vec3& max, int axis, int side, bool inwards);
  /// Prism over a convex polygon in the plane y = `bottom`, counter-clockwise seen from above; all faces outwards.
  MeshBuilder& prism(const std::vector<glm::vec2>& polygon_xz, float bottom, float top);

  /// Smooth faces: vertices with their own normals, to be joined by index.
  uint32_t vertex(const glm::vec3& position, const glm::vec3& normal);
  /// Leaves out triangles without area.
  MeshBuilder& face(uint32_t a, uint32_t b, uint32_t c);

  /// A smooth sheet: `rows` by `columns` positions, row by row; normals are averaged from its faces. Faces run
  /// (row, column), (row, column + 1), (row + 1, column + 1) counter-clockwise seen from the front. `closed` joins the
  /// last column to the first.
  MeshBuilder& sheet(const std::vector<glm::vec3>& positions, size_t rows, size_t columns, bool closed);

  /// Surface of revolution about the Y axis from points (radius, y), upwards = facing outwards. Each part is smooth;
  /// parts meet in creases.
  MeshBuilder& revolve(const std::vector<std::vector<glm::vec2>>& parts, size_t segments);

  /// A closed polygon (d, y), counter-clockwise with d to the right, swept around the rectangle |x| = half.x,
  /// |z| = half.y: d is the distance outwards from it. Mitred corners, closed, faces outwards.
  MeshBuilder& sweep_around(const std::vector<glm::vec2>& polygon, const glm::vec2& half);

  Mesh take() { return std::move(mesh_); }
  size_t triangle_count() const { return mesh_.triangles.size(); }

 private:
  Mesh mesh_;
};

/// A pure Lambert material: index of refraction 1, so that it has no specular lobe.
int add_lambert(Scene& scene, const std::string& name, const glm::vec3& albedo);
/// Black body that emits `radiance` [cd/m²] per channel.
int add_emitter(Scene& scene, const std::string& name, const glm::vec3& radiance);
int add_metal(Scene& scene, const std::string& name, const glm::vec3& color, float roughness);
/// A rough dielectric (index of refraction 1.5).
int add_dielectric(Scene& scene, const std::string& name, const glm::vec3& color, float roughness);

/// Adds a mesh; returns its index.
int add_mesh(Scene& scene, Mesh mesh);
/// An occurrence of it.
void add_instance(Scene& scene, int mesh, int material, const glm::mat4& world_from_object = glm::mat4(1.f));

/// A node at `position` with an occurrence of it, to be animated; returns the node's index.
int add_node_instance(Scene& scene, int mesh, int material, const glm::vec3& position);

/// A clear sky without the sun's disc: blue overhead, pale at the horizon, grey ground below it.
Environment clear_sky(float strength);

/// A smooth walk of the camera, named "walk"; fields of view as given.
CameraPath walk(const std::vector<CameraKey>& keys);

/// Golden-ratio icosahedron with every triangle cut into four `levels` times, corners on the unit sphere.
std::vector<std::array<glm::vec3, 3>> icosphere(int levels);

Scene make_cornell(const std::string& variant);  ///< "", "mirror" or "glossy"
Scene make_furnace();
Scene make_room(int lamp);     ///< what lights it: see the parameter in scenes.cpp
Scene make_fixture(int lamp);  ///< 0: a point light, 1: a lamp of 4 cm
Scene make_caustic();
/// 20 · 4^levels triangles; roughness in hundredths.
Scene make_statue(int levels, int roughness);
Scene make_atrium();
Scene make_lamps(int count);
Scene make_picture_lamp();
Scene make_spheres();
Scene make_solids();
Scene make_debris(int pieces);
Scene make_mirror_hall();
/// `triangles` of the whole scene if its lamp has two; it has `lights`.
Scene make_blocks(int triangles, int lights);

}  // namespace lucarium
