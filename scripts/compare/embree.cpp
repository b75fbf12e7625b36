// The measurements of Embree, on the meshes and rays that `peers` has written. One measurement for each call, with one line
// of JSON as the result.
//   embree build MESH                 a HIGH quality build
//   embree trace MESH RAYS single|packets16 [robust|cached]
// Times are CPU seconds of this process. They include the preparation of rays, but not the reading of files.
#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

// Rays begin at a small distance: Embree has no other means to skip the triangle that they start on.
constexpr float near = 1e-4f;
constexpr int width = 16;
// Packets that are traced repeatedly before the next ones, so that they are in the second cache.
constexpr std::size_t together = 512;

struct Packet {
  float origin[3][width];
  float direction[3][width];
  std::uint32_t alive;
};

double seconds() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

template <class T>
std::vector<T> read(const char* file) {
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  if (!stream) throw std::runtime_error(std::string(file) + ": cannot be read");
  std::vector<T> items(std::size_t(stream.tellg()) / sizeof(T));
  stream.seekg(0);
  stream.read(reinterpret_cast<char*>(items.data()), std::streamsize(items.size() * sizeof(T)));
  return items;
}

struct Scene {
  RTCDevice device = rtcNewDevice("threads=1");
  RTCScene scene = rtcNewScene(device);
  double built = 0.0;

  Scene(const char* file, bool robust) {
    const auto words = read<std::uint32_t>(file);
    const std::size_t positions = words.at(0), triangles = words.at(1);
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* corners = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, positions);
    std::memcpy(corners, words.data() + 2, 12 * positions);
    void* indices = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, triangles);
    std::memcpy(indices, words.data() + 2 + 3 * positions, 12 * triangles);
    rtcSetGeometryBuildQuality(mesh, RTC_BUILD_QUALITY_HIGH);
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(scene, mesh);
    rtcReleaseGeometry(mesh);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    if (robust) rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    const double start = seconds();
    rtcCommitScene(scene);
    built = seconds() - start;
    if (rtcGetDeviceError(device) != RTC_ERROR_NONE) throw std::runtime_error("Embree refuses the scene");
  }
  ~Scene() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
};

struct Tally {
  std::uint64_t rays = 0, hits = 0;
  double sum = 0.0;

  void enter(bool hit, float distance) {
    ++rays;
    if (!hit) return;
    ++hits;
    sum += double(distance);
  }
};

void single(RTCScene scene, const Packet& packet, RTCIntersectContext& context, Tally& tally) {
  for (int lane = 0; lane < width; ++lane) {
    if (!(packet.alive >> lane & 1)) continue;
    RTCRayHit ray;
    ray.ray.org_x = packet.origin[0][lane];
    ray.ray.org_y = packet.origin[1][lane];
    ray.ray.org_z = packet.origin[2][lane];
    ray.ray.dir_x = packet.direction[0][lane];
    ray.ray.dir_y = packet.direction[1][lane];
    ray.ray.dir_z = packet.direction[2][lane];
    ray.ray.tnear = near;
    ray.ray.tfar = std::numeric_limits<float>::infinity();
    ray.ray.time = 0.0f;
    ray.ray.mask = ~0u;
    ray.ray.flags = 0;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &context, &ray);
    tally.enter(ray.hit.geomID != RTC_INVALID_GEOMETRY_ID, ray.ray.tfar);
  }
}

void sixteen(RTCScene scene, const Packet& packet, RTCIntersectContext& context, Tally& tally) {
  RTCRayHit16 rays;
  std::memcpy(rays.ray.org_x, packet.origin[0], sizeof packet.origin[0]);
  std::memcpy(rays.ray.org_y, packet.origin[1], sizeof packet.origin[1]);
  std::memcpy(rays.ray.org_z, packet.origin[2], sizeof packet.origin[2]);
  std::memcpy(rays.ray.dir_x, packet.direction[0], sizeof packet.direction[0]);
  std::memcpy(rays.ray.dir_y, packet.direction[1], sizeof packet.direction[1]);
  std::memcpy(rays.ray.dir_z, packet.direction[2], sizeof packet.direction[2]);
  alignas(64) int valid[width];
  for (int lane = 0; lane < width; ++lane) {
    valid[lane] = packet.alive >> lane & 1 ? -1 : 0;
    rays.ray.tnear[lane] = near;
    rays.ray.tfar[lane] = std::numeric_limits<float>::infinity();
    rays.ray.time[lane] = 0.0f;
    rays.ray.mask[lane] = ~0u;
    rays.ray.flags[lane] = 0;
    rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
  }
  rtcIntersect16(valid, scene, &context, &rays);
  for (int lane = 0; lane < width; ++lane)
    if (valid[lane]) tally.enter(rays.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID, rays.ray.tfar[lane]);
}

int trace(const char* mesh, const char* rays, bool packets16, bool robust, int repeats) {
  const Scene scene(mesh, robust);
  const auto packets = read<Packet>(rays);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  // A packet has sixteen wavelengths of one pixel, whose rays are close together at first.
  context.flags = packets16 ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  Tally tally;
  const double start = seconds();
  for (std::size_t first = 0; first < packets.size(); first += together)
    for (int repeat = 0; repeat < repeats; ++repeat) {
      const std::size_t last = std::min(first + together, packets.size());
      for (std::size_t k = first; k < last; ++k)
        packets16 ? sixteen(scene.scene, packets[k], context, tally) : single(scene.scene, packets[k], context, tally);
    }
  const double cpu = (seconds() - start) / repeats;
  const std::uint64_t times = repeats;
  std::printf("{\"cpu\": %.9g, \"rays\": %llu, \"hits\": %llu, \"mean\": %.9g}\n", cpu,
              static_cast<unsigned long long>(tally.rays / times),
              static_cast<unsigned long long>(tally.hits / times), tally.sum / double(tally.hits));
  return 0;
}

int run(int count, char** arguments) {
  const std::string what = count > 1 ? arguments[1] : "";
  if (what == "build" && count == 3) {
    std::printf("{\"cpu\": %.9g}\n", Scene(arguments[2], false).built);
    return 0;
  }
  if (what == "trace" && count >= 5) {
    const std::string more = count > 5 ? arguments[5] : "";
    const std::string mode = arguments[4];
    return trace(arguments[2], arguments[3], mode == "packets16", more == "robust", more == "cached" ? 20 : 1);
  }
  throw std::runtime_error("usage: embree build MESH | trace MESH RAYS single|packets16 [robust|cached]");
}

}  // namespace

int main(int count, char** arguments) {
  try {
    return run(count, arguments);
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "embree: %s\n", failure.what());
    return 1;
  }
}
