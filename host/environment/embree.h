// SPDX-License-Identifier: Apache-2.0
// Wrapper of Embree, versions 3 and 4: no other file of the project uses an Embree type or depends on its version.
// Debian's Embree 3 is built with assertions and aborts on NaN, infinite or overlarge rays, so every query is checked
// here first and returns "no hit" instead.
#pragma once
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <mutex>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

namespace malha {

namespace embree_detail {

struct Release {
  void operator()(RTCDevice device) const {
    if (device != nullptr) rtcReleaseDevice(device);
  }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};

/// The last error that Embree reported. It calls back from inside its own handlers and threads, where throwing is
/// unsafe: the message is stored here and thrown by Device::check on return.
struct ErrorLog {
  std::mutex mutex;
  std::string message;
  RTCError code = RTC_ERROR_NONE;
};

inline void log_error(void* user, RTCError code, const char* text) {
  auto& log = *static_cast<ErrorLog*>(user);
  const std::lock_guard lock(log.mutex);
  if (log.message.empty()) {
    log.message = "Embree: error " + std::to_string(static_cast<int>(code)) + ": " + (text ? text : "unknown");
    log.code = code;
  }
}

/// Throws an Embree error: std::bad_alloc if it ran out of memory, otherwise std::runtime_error.
[[noreturn]] inline void throw_error(RTCError code, const std::string& message) {
  if (code == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  throw std::runtime_error(message);
}

/// Embree's own bound for a valid coordinate (its FLT_LARGE is 1.844e18); false for NaN.
inline bool is_valid(const std::array<float, 3>& v) {
  constexpr float kLarge = 1.8e18f;
  return std::fabs(v[0]) <= kLarge && std::fabs(v[1]) <= kLarge && std::fabs(v[2]) <= kLarge;
}

inline bool is_valid(const std::array<float, 3>& origin, const std::array<float, 3>& direction, float t_near,
                     float t_far) {
  const bool moves = direction[0] != 0 || direction[1] != 0 || direction[2] != 0;
  return is_valid(origin) && is_valid(direction) && moves && t_near >= 0 && t_near <= t_far;
}

inline void set_ray(RTCRay& ray, const std::array<float, 3>& origin, const std::array<float, 3>& direction,
                    float t_near, float t_far) {
  ray.org_x = origin[0];
  ray.org_y = origin[1];
  ray.org_z = origin[2];
  ray.dir_x = direction[0];
  ray.dir_y = direction[1];
  ray.dir_z = direction[2];
  ray.tnear = t_near;
  ray.tfar = t_far;
  ray.time = 0;
  ray.mask = 0xffffffffu;
  ray.id = 0;
  ray.flags = 0;
}

}  // namespace embree_detail

/// An Embree device, which its scenes share: Embree 3.13 reads a device while it frees the memory of a scene, but a
/// scene that has the last reference releases the device first.
class Device {
 public:
  /// `threads` build the scenes (queries run on the caller's). One by default: with more, the order of the primitives
  /// in a tree, and with it which of two equally near triangles wins, depends on timing.
  explicit Device(int threads = 1)
      : log_(std::make_shared<embree_detail::ErrorLog>()),
        device_(rtcNewDevice(("threads=" + std::to_string(threads)).c_str()), embree_detail::Release()) {
    if (!device_) {
      const RTCError code = rtcGetDeviceError(nullptr);
      embree_detail::throw_error(code, "Embree: no device, error " + std::to_string(static_cast<int>(code)));
    }
    rtcSetDeviceErrorFunction(device_.get(), embree_detail::log_error, log_.get());
  }

  /// Throws the first error that Embree reported since the last call: std::runtime_error, or std::bad_alloc for memory.
  void check() const {
    const std::lock_guard lock(log_->mutex);
    if (log_->message.empty()) return;
    embree_detail::throw_error(std::exchange(log_->code, RTC_ERROR_NONE), std::exchange(log_->message, {}));
  }

  RTCDevice get() const { return device_.get(); }

 private:
  std::shared_ptr<embree_detail::ErrorLog> log_;  // declared first: it outlives the device, which refers to it
  std::shared_ptr<RTCDeviceTy> device_;
};

/// A scene of triangles, spheres and capsules for ray queries, in ROBUST mode. Add, commit once, then query from any
/// thread. Every add_* returns the geometry's number (Hit::geometry), or -1 for nothing to add. Throws
/// std::runtime_error on Embree's errors.
class RayScene {
 public:
  explicit RayScene(const Device& device) : device_(device), scene_(rtcNewScene(device.get())) {
    rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
    device.check();
  }

  /// Triangles that refer to points outside Embree's range (1.8e18) or to NaN are never hit.
  int add_triangles(std::span<const std::array<float, 3>> points, std::span<const std::array<int, 3>> triangles) {
    if (triangles.empty()) return -1;
    auto geometry = make(RTC_GEOMETRY_TYPE_TRIANGLE);
    fill(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, points);
    fill(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, triangles);
    return attach(geometry);
  }

  /// Spheres (x, y, z, radius).
  int add_spheres(std::span<const std::array<float, 4>> spheres) {
    if (spheres.empty()) return -1;
    auto geometry = make(RTC_GEOMETRY_TYPE_SPHERE_POINT);
    fill(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, spheres);
    return attach(geometry);
  }

  /// Capsule i joins the spheres (x, y, z, radius) 2 i and 2 i + 1. Rays along its axis miss it (seen in 3.13): add
  /// spheres at the ends where that matters.
  int add_capsules(std::span<const std::array<float, 4>> ends) {
    if (ends.empty()) return -1;
    auto geometry = make(RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE);
    fill(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, ends);
    auto* first = static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0,
                                                                 RTC_FORMAT_UINT, sizeof(unsigned), ends.size() / 2));
    device_.check();
    for (unsigned i = 0; i < ends.size() / 2; ++i) first[i] = 2 * i;
    return attach(geometry);
  }

  void commit() {
    rtcCommitScene(scene_.get());
    device_.check();
  }

  RTCScene get() const { return scene_.get(); }

 private:
  using Geometry = std::unique_ptr<RTCGeometryTy, embree_detail::Release>;

  Geometry make(RTCGeometryType type) {
    Geometry geometry(rtcNewGeometry(device_.get(), type));
    device_.check();
    rtcSetGeometryMask(geometry.get(), 0xffffffffu);  // version 4 ignores geometries without it
    return geometry;
  }

  template <class T>
  void fill(const Geometry& geometry, RTCBufferType type, RTCFormat format, std::span<const T> values) {
    void* to = rtcSetNewGeometryBuffer(geometry.get(), type, 0, format, sizeof(T), values.size());
    device_.check();
    std::memcpy(to, values.data(), values.size_bytes());
  }

  int attach(const Geometry& geometry) {
    rtcCommitGeometry(geometry.get());
    const unsigned number = rtcAttachGeometry(scene_.get(), geometry.get());
    device_.check();
    return static_cast<int>(number);
  }

  Device device_;  // declared first
  std::unique_ptr<RTCSceneTy, embree_detail::Release> scene_;
};

/// A scene of one triangle mesh, ready for queries.
class TriangleScene : public RayScene {
 public:
  TriangleScene(const Device& device, std::span<const std::array<float, 3>> points,
                std::span<const std::array<int, 3>> triangles)
      : RayScene(device) {
    add_triangles(points, triangles);
    commit();
  }
};

/// The nearest hit: at origin + t direction; `triangle` counts within its geometry (a sphere or capsule likewise);
/// (1 - u - v, u, v) are barycentric; the normal is geometric and not normalised, (p1 - p0) x (p2 - p0) on triangles.
struct Hit {
  bool hit = false;
  float t = 0;
  int triangle = -1;
  float u = 0, v = 0;
  std::array<float, 3> normal{0, 0, 0};
  int geometry = -1;
};

/// The hit with the least t in [t_near, t_far]. No hit for a ray that is not finite (t_far may be infinite), has a zero
/// direction, or has t_near < 0 or > t_far.
inline Hit intersect(const RayScene& scene, const std::array<float, 3>& origin, const std::array<float, 3>& direction,
                     float t_near, float t_far) {
  if (!embree_detail::is_valid(origin, direction, t_near, t_far)) return {};
  RTCRayHit query;
  embree_detail::set_ray(query.ray, origin, direction, t_near, t_far);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(scene.get(), &query, nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene.get(), &context, &query);
#endif
  const RTCHit& hit = query.hit;
  if (hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return {true,
          query.ray.tfar,
          static_cast<int>(hit.primID),
          hit.u,
          hit.v,
          {hit.Ng_x, hit.Ng_y, hit.Ng_z},
          static_cast<int>(hit.geomID)};
}

/// Returns true if anything lies on the ray within [t_near, t_far]; false where intersect() would reject the ray.
inline bool occluded(const RayScene& scene, const std::array<float, 3>& origin, const std::array<float, 3>& direction,
                     float t_near, float t_far) {
  if (!embree_detail::is_valid(origin, direction, t_near, t_far)) return false;
  RTCRay ray;
  embree_detail::set_ray(ray, origin, direction, t_near, t_far);
#if RTC_VERSION_MAJOR >= 4
  rtcOccluded1(scene.get(), &ray, nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene.get(), &context, &ray);
#endif
  return ray.tfar < 0;  // Embree sets it to minus infinity on a hit
}

/// Calls `float on_triangle(int triangle)` for every triangle whose bounding box may lie within `radius` of `point`.
/// The callback returns the radius to search from now on; a larger one changes nothing. It must not throw: Embree's
/// frames lie in between. Nothing is called for a point or radius that is not finite, or a negative radius.
template <class F>
void point_query(const TriangleScene& scene, const std::array<float, 3>& point, float radius, F&& on_triangle) {
  if (!embree_detail::is_valid(point) || !(radius >= 0) || !std::isfinite(radius)) return;
  RTCPointQuery query;
  query.x = point[0];
  query.y = point[1];
  query.z = point[2];
  query.time = 0;
  query.radius = radius;
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  using Callback = std::remove_reference_t<F>;
  const auto call = [](RTCPointQueryFunctionArguments* arguments) {
    auto& callback = *static_cast<Callback*>(arguments->userPtr);
    const float shrunk = callback(static_cast<int>(arguments->primID));
    if (!(shrunk < arguments->query->radius)) return false;
    arguments->query->radius = shrunk;
    return true;
  };
  void* user = const_cast<void*>(static_cast<const void*>(std::addressof(on_triangle)));
  rtcPointQuery(scene.get(), &query, &context, call, user);
}

}  // namespace malha
