// SPDX-License-Identifier: Apache-2.0
// builtin:debris: a ball that bursts into closed pieces, the Voronoi cells of random points. Each piece flies on a
// straight line and turns about its own axis: a morph of one mesh, so that every piece stays rigid. Declared in
// builder.h.
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <random>

#include "lucarium/scene/builtin/builder.h"
#include "lucarium/scene/builtin/voronoi.h"

namespace lucarium {

namespace {

constexpr double radius = 0.7, crack = 0.08;  // cracks: how far the pieces stand apart at first, over their distances
constexpr float seconds = 2;
constexpr glm::vec4 glaze{0.08f, 0.30f, 0.62f, 1}, clay{0.78f, 0.42f, 0.22f, 1};

/// Uniform over [0, 1), the same with every standard library.
class Random {
 public:
  double operator()() { return static_cast<double>(generator_()) * 0x1p-32; }
  glm::dvec3 in_ball() {
    for (;;) {
      const double x = (*this)(), y = (*this)(), z = (*this)();
      const glm::dvec3 p = 2. * glm::dvec3(x, y, z) - 1.;
      if (glm::dot(p, p) < 1) return p;
    }
  }

 private:
  std::mt19937 generator_{1};
};

/// The ball, of unit radius: planes of an icosphere's faces.
std::vector<HalfSpace> ball_faces() {
  std::vector<HalfSpace> faces;
  for (const auto& [a, b, c] : icosphere(3)) {
    const glm::dvec3 n = glm::normalize(glm::cross(glm::dvec3(b) - glm::dvec3(a), glm::dvec3(c) - glm::dvec3(a)));
    faces.push_back({n, glm::dot(n, glm::dvec3(a))});
  }
  return faces;
}

std::vector<ConvexCell> ball_pieces(int count, Random& random) {
  const std::vector<HalfSpace> faces = ball_faces();
  double inner = 1;
  for (const HalfSpace& face : faces) inner = std::min(inner, face.offset);
  std::vector<glm::dvec3> points;
  for (int i = 0; i < count; ++i) points.push_back(0.99 * inner * random.in_ball());
  std::vector<ConvexCell> pieces = voronoi_cells(points, faces, inner, 1.01);
  const double size = std::cbrt(4. / count);
  for (ConvexCell& piece : pieces) collapse_short_edges(piece, 2e-3 * size);
  return pieces;
}

using Polygon = std::vector<glm::dvec3>;

/// Twice the area, along the normal.
glm::dvec3 area_vector(const Polygon& polygon) {
  glm::dvec3 sum(0);
  for (size_t i = 1; i + 1 < polygon.size(); ++i)
    sum += glm::cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]);
  return sum;
}

/// The face as polygons that are flat, each to be cut into a fan around its first corner: the corner without slivers.
/// Where edges were collapsed, a face may be bent: then its triangles are apart.
std::vector<Polygon> flat_parts(const ConvexCell& cell, const std::vector<uint32_t>& loop) {
  const auto corner = [&](size_t i) { return cell.corners[loop[i % loop.size()]]; };
  std::vector<Polygon> best;
  double best_area = -1;
  for (size_t first = 0; first < loop.size(); ++first) {
    std::vector<Polygon> fan;
    double smallest = INFINITY;
    for (size_t i = first + 1; i + 1 < first + loop.size(); ++i) {
      fan.push_back({corner(first), corner(i), corner(i + 1)});
      smallest = std::min(smallest, glm::length(area_vector(fan.back())));
    }
    if (smallest > best_area) best_area = smallest, best = std::move(fan);
  }
  Polygon whole = {best[0][0], best[0][1]};
  for (const Polygon& triangle : best) whole.push_back(triangle[2]);
  const glm::dvec3 normal = glm::normalize(area_vector(whole));
  for (const Polygon& triangle : best) {
    if (glm::dot(glm::normalize(area_vector(triangle)), normal) < 0.999) return best;
  }
  return {whole};
}

/// How one piece moves: weights of the targets are t, cos θ − 1 and sin θ, t in units of the animation and θ the common
/// angle of turn, so that p + t v + (cos θ − 1) q + sin θ (axis × q) is rigid; q is perpendicular to the axis.
struct Motion {
  glm::dvec3 centre, velocity, axis;
};

void add_piece(const ConvexCell& cell, const Motion& motion, Mesh& mesh) {
  const auto target = [&](size_t k, const glm::dvec3& position, const glm::dvec3& normal) {
    mesh.morph_targets[k].positions.emplace_back(position);
    mesh.morph_targets[k].normals.emplace_back(normal);
  };
  const auto across = [&](const glm::dvec3& v) { return v - glm::dot(v, motion.axis) * motion.axis; };
  for (const ConvexCell::Face& face : cell.faces) {
    for (const Polygon& part : flat_parts(cell, face.corners)) {
      const glm::dvec3 normal = glm::normalize(area_vector(part));
      const auto first = static_cast<uint32_t>(mesh.positions.size());
      for (const glm::dvec3& p : part) {
        const glm::dvec3 arm = p - motion.centre;
        mesh.positions.emplace_back(radius * (p + crack * motion.centre));
        mesh.normals.emplace_back(normal);
        mesh.colors.emplace_back(face.outer ? glaze : clay);
        target(0, motion.velocity, glm::dvec3(0));
        target(1, radius * across(arm), across(normal));
        target(2, radius * glm::cross(motion.axis, arm), glm::cross(motion.axis, normal));
      }
      for (uint32_t i = 1; i + 1 < part.size(); ++i) mesh.triangles.emplace_back(first, first + i, first + i + 1);
    }
  }
}

Mesh burst_ball(int pieces) {
  Random random;
  Mesh mesh;
  mesh.name = "pieces";
  mesh.morph_targets.resize(3);
  for (const ConvexCell& cell : ball_pieces(pieces, random)) {
    Motion motion{glm::dvec3(0), glm::dvec3(0), glm::dvec3(0, 1, 0)};
    for (const glm::dvec3& p : cell.corners) motion.centre += p / static_cast<double>(cell.corners.size());
    const glm::dvec3 stray = random.in_ball();
    motion.velocity = radius * ((1.3 + 0.7 * random()) * motion.centre + 0.08 * stray);
    motion.axis = glm::normalize(random.in_ball() + 1e-9);
    add_piece(cell, motion, mesh);
  }
  return mesh;
}

/// Weights over time, as splines: linear flight, turn by 0.5 rad/s² t².
AnimationChannel burst(int node) {
  AnimationChannel channel{.node = node,
                           .path = AnimationPath::weights,
                           .interpolation = Interpolation::cubic_spline,
                           .times = {},
                           .values = {}};
  constexpr int keys = 25;
  for (int key = 0; key < keys; ++key) {
    const float t = seconds * static_cast<float>(key) / (keys - 1), angle = 0.5f * t * t, speed = t;
    channel.times.push_back(t);
    const float value[3] = {t / seconds, std::cos(angle) - 1, std::sin(angle)};
    const float slope[3] = {1 / seconds, -speed * std::sin(angle), speed * std::cos(angle)};
    for (const float* part : {slope, value, slope}) channel.values.insert(channel.values.end(), part, part + 3);
  }
  return channel;
}

}  // namespace

Scene make_debris(int pieces) {
  Scene scene;
  const int floor = add_lambert(scene, "floor", {0.60f, 0.58f, 0.55f});
  const int pottery = add_lambert(scene, "pottery", glm::vec3(0.8f));
  const int lamp = add_emitter(scene, "lamp", {260.f, 224.f, 172.f});
  add_instance(scene, add_mesh(scene, MeshBuilder("floor").box({-2.4f, -0.2f, -2.4f}, {2.4f, 0, 2.4f}).take()), floor);
  const int node = add_node_instance(scene, add_mesh(scene, burst_ball(pieces)), pottery, {0, 2.3f, 0});
  scene.nodes[node].morph_weights = {0, 0, 0};
  MeshBuilder bulb("lamp");
  for (const auto& [a, b, c] : icosphere(2)) bulb.triangle(0.25f * a, 0.25f * b, 0.25f * c);
  add_node_instance(scene, add_mesh(scene, bulb.take()), lamp, {-2.2f, 4.2f, 1.8f});
  scene.animations.push_back({.name = "burst", .channels = {burst(node)}, .duration = seconds});

  scene.environment = clear_sky(0.3f);
  scene.cameras.push_back(look_at_camera("front", {0.7f, 2.1f, 5.4f}, {0, 1.85f, 0}, 45.f));
  scene.cameras.push_back(look_at_camera("below", {1.6f, 0.35f, 2.2f}, {-0.1f, 2.2f, 0}, 62.f));
  scene.cameras.push_back(look_at_camera("inside", {0.f, 2.3f, 1.2f}, {0, 2.3f, 0}, 70.f));
  return scene;
}

}  // namespace lucarium
