#pragma once

// What an engineer would write in an afternoon over the same libraries: rays by Embree, noise, intensity and label from
// what they meet, rows, a file for each scan. The yardstick of the whole way to a dataset. It knows one still sensor of
// one kind, opaque meshes and these columns alone.

#include <pcl/PCLPointCloud2.h>
#include <pcl/io/pcd_io.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "scene/scene.h"
#include "sensors/beams.h"
#include "sensors/shot.h"
#include "tests/benchmarks/bare_draco.h"
#include "tests/benchmarks/bare_embree.h"

namespace scanmill {

enum class HandWrittenFormat { Pcd, CompressedPcd, Draco };

class HandWritten {
 public:
  // The scene is moved by -origin, so that float32 suffices.
  HandWritten(const Scene& from, const BeamTable& beams, const Vec3d& origin)
      : beams_(beams), origin_(origin), scene_(from, origin) {
    for (const Instance& instance : from.instances) {
      const Mesh& mesh = from.meshes[instance.mesh];
      for (const std::uint16_t number : mesh.surfaceOf) {
        const Surface& surface = mesh.surfaces[number];
        facts_.push_back({from.materials[surface.material].reflectance, surface.semantic,
                          surface.object == 0 ? 0 : instance.firstInstanceId + surface.object - 1});
      }
    }
  }

  // All scans on all cores, a file each. The sensors stand still. Returns the number of points.
  std::size_t writeScans(const std::vector<Pose>& worldFromSensor, HandWrittenFormat format,
                         const std::filesystem::path& folder) const {
    std::filesystem::create_directories(folder);
    std::atomic<std::size_t> points = 0;
    parallelFor(worldFromSensor.size(), 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        std::vector<Row> rows;
        rows.reserve(beams_.size());
        trace(worldFromSensor[i], static_cast<unsigned>(i), rows);
        points += rows.size();
        write(rows, format, folder / std::to_string(i));
      }
    });
    return points;
  }

 private:
  struct Facts {
    float reflectance;
    std::uint16_t label;
    std::uint32_t instance;
  };
  struct Row {
    float x, y, z, intensity;
    std::uint32_t label, instance;
    std::uint16_t ring, column;
  };
  static constexpr unsigned kWide = 16;

  void trace(const Pose& pose, unsigned seed, std::vector<Row>& rows) const {
    const Mat3 rotation = toMatrix(pose.rotation);
    const std::array<float, 9> turn = [&] {
      const Vec3d x = rotation * Vec3d{1, 0, 0};
      const Vec3d y = rotation * Vec3d{0, 1, 0};
      const Vec3d z = rotation * Vec3d{0, 0, 1};
      return std::array<float, 9>{float(x.x), float(y.x), float(z.x), float(x.y), float(y.y),
                                  float(z.y), float(x.z), float(y.z), float(z.z)};
    }();
    const Vec3f from(pose.translation - origin_);
    std::mt19937 generator(seed);
    std::normal_distribution<float> noise(0, 0.02f);
    alignas(64) int valid[kWide];
    std::fill_n(valid, kWide, -1);
    alignas(64) RTCRayHit16 packet;
    std::array<Vec3f, kWide> own;
    // Packets of 16 neighbours of a ring: faster here than 16 rings of a column.
    for (std::uint32_t ring = 0; ring < beams_.rings; ++ring) {
      for (std::uint32_t column = 0; column < beams_.columns; column += kWide) {
        for (unsigned k = 0; k < kWide; ++k) {
          own[k] = Vec3f(beams_.direction[std::size_t{ring} * beams_.columns + column + k]);
          const Vec3f& d = own[k];
          packet.ray.org_x[k] = from.x;
          packet.ray.org_y[k] = from.y;
          packet.ray.org_z[k] = from.z;
          packet.ray.dir_x[k] = turn[0] * d.x + turn[1] * d.y + turn[2] * d.z;
          packet.ray.dir_y[k] = turn[3] * d.x + turn[4] * d.y + turn[5] * d.z;
          packet.ray.dir_z[k] = turn[6] * d.x + turn[7] * d.y + turn[8] * d.z;
          packet.ray.tnear[k] = static_cast<float>(beams_.minRange);
          packet.ray.tfar[k] = static_cast<float>(beams_.maxRange);
          packet.ray.time[k] = 0;
          packet.ray.mask[k] = ~0u;
          packet.ray.id[k] = k;
          packet.ray.flags[k] = 0;
          packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
          packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
        }
        EmbreeContext context = newEmbreeContext();
        intersectPacket(scene_.get(), context, valid, packet);
        for (unsigned k = 0; k < kWide; ++k) {
          if (packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
          const Vec3f normal{packet.hit.Ng_x[k], packet.hit.Ng_y[k], packet.hit.Ng_z[k]};
          const Vec3f ray{packet.ray.dir_x[k], packet.ray.dir_y[k], packet.ray.dir_z[k]};
          const Facts& facts = facts_[packet.hit.primID[k]];
          const float cosine = std::abs(dot(normal, ray)) / std::sqrt(dot(normal, normal));
          const float range = packet.ray.tfar[k] + noise(generator);
          rows.push_back({range * own[k].x, range * own[k].y, range * own[k].z,
                          std::round(255 * std::min(1.0f, facts.reflectance * cosine)), facts.label, facts.instance,
                          static_cast<std::uint16_t>(ring), static_cast<std::uint16_t>(column + k)});
        }
      }
    }
  }

  static void write(const std::vector<Row>& rows, HandWrittenFormat format, const std::filesystem::path& file) {
    std::ofstream out(file, std::ios::binary);
    if (format == HandWrittenFormat::Pcd) {
      out << "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity label instance ring time\nSIZE 4 4 4 4 4 4 4 4\n"
          << "TYPE F F F F U U U F\nCOUNT 1 1 1 1 1 1 1 1\nWIDTH " << rows.size()
          << "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << rows.size() << "\nDATA binary\n";
      out.write(reinterpret_cast<const char*>(rows.data()), static_cast<std::streamsize>(rows.size() * sizeof(Row)));
    } else if (format == HandWrittenFormat::CompressedPcd) {
      pcl::PCDWriter().writeBinaryCompressed(out, pclCloud(rows));
    } else {
      const std::string bytes = bareDracoBytes(scanOf(rows));
      out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
  }

  static pcl::PCLPointCloud2 pclCloud(const std::vector<Row>& rows) {
    pcl::PCLPointCloud2 cloud;
    cloud.width = static_cast<std::uint32_t>(rows.size());
    cloud.height = 1;
    cloud.point_step = sizeof(Row);
    cloud.row_step = cloud.point_step * cloud.width;
    const auto add = [&](const char* name, std::uint8_t type, std::uint32_t offset) {
      pcl::PCLPointField field;
      field.name = name;
      field.offset = offset;
      field.datatype = type;
      field.count = 1;
      cloud.fields.push_back(field);
    };
    add("x", pcl::PCLPointField::FLOAT32, offsetof(Row, x));
    add("y", pcl::PCLPointField::FLOAT32, offsetof(Row, y));
    add("z", pcl::PCLPointField::FLOAT32, offsetof(Row, z));
    add("intensity", pcl::PCLPointField::FLOAT32, offsetof(Row, intensity));
    add("label", pcl::PCLPointField::UINT32, offsetof(Row, label));
    add("instance", pcl::PCLPointField::UINT32, offsetof(Row, instance));
    add("ring", pcl::PCLPointField::UINT16, offsetof(Row, ring));
    add("column", pcl::PCLPointField::UINT16, offsetof(Row, column));
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(rows.data());
    cloud.data.assign(bytes, bytes + rows.size() * sizeof(Row));
    return cloud;
  }

  static Scan scanOf(const std::vector<Row>& rows) {
    Scan scan;
    for (const Row& row : rows) {
      scan.position.push_back({row.x, row.y, row.z});
      scan[kIntensity].push_back(row.intensity);
      scan[kLabel].push_back(static_cast<std::uint16_t>(row.label));
      scan[kInstance].push_back(row.instance);
      scan[kRing].push_back(row.ring);
      scan[kColumn].push_back(row.column);
    }
    return scan;
  }

  const BeamTable& beams_;
  Vec3d origin_;
  BareScene scene_;
  std::vector<Facts> facts_;
};

}  // namespace scanmill
