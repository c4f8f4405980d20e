#include "kinetrace/publishing/ros_reader.hpp"

#include <array>
#include <string_view>
#include <utility>

#include <dds/ddsi/ddsi_serdata.h>

#include "kinetrace/publishing/ros_definitions.hpp"
#include "ros/ros_topic_table.hpp"
#include "transport/topic_reader.hpp"

namespace kinetrace::publishing {
namespace {

// Buffers messages while a disk is slow; of /tf_static, one from each sending node.
constexpr std::int32_t kDepth = 64;

/// "nav_msgs::msg::dds_::Odometry_" becomes "nav_msgs/msg/Odometry".
std::string ros_type(std::string_view dds_type) {
  constexpr std::string_view kWire = "dds_::";
  std::string type(dds_type.substr(0, dds_type.size() - 1));
  if (const std::size_t at = type.find(kWire); at != std::string::npos) {
    type.erase(at, kWire.size());
  }
  for (std::size_t at = type.find("::"); at != std::string::npos; at = type.find("::")) {
    type.replace(at, 2, 1, '/');
  }
  return type;
}

/// In the format of ROS's recorder, with the numbers of its middleware interface.
std::string offered_qos(const TopicQos& qos) {
  constexpr std::string_view kForever = "    sec: 9223372036\n    nsec: 854775807\n";
  const std::string forever(kForever);
  return "- history: 1\n  depth: " + std::to_string(qos.depth) +
         "\n  reliability: 1\n  durability: " + (qos.keeps_last ? "1" : "2") + "\n  deadline:\n" + forever +
         "  lifespan:\n" + forever + "  liveliness: 1\n  liveliness_lease_duration:\n" + forever +
         "  avoid_ros_namespace_conventions: false\n";
}

using Readers = std::array<TopicReader, kRosTopicCount>;

Result<Readers> make_readers(const Link& link, const LinkMembership& membership, const std::string& prefix) {
  Readers readers;
  for (std::size_t i = 0; i < readers.size(); ++i) {
    const RosTopicKind& kind = kind_of(static_cast<RosTopic>(i));
    TopicQos qos = kind.qos;
    qos.depth = kDepth;
    Result<TopicReader> reader = TopicReader::create(link, membership, *kind.type, kind.dds_name(prefix), qos);
    if (!reader) {
      return Unexpected(reader.error());
    }
    readers[i] = std::move(*reader);
  }
  return readers;
}

struct Unref {
  void operator()(ddsi_serdata* data) const noexcept { ddsi_serdata_unref(data); }
};
using SerializedData = std::unique_ptr<ddsi_serdata, Unref>;

/// The next serialized message; null if there is none.
SerializedData take_one(dds_entity_t reader, dds_sample_info_t& info) noexcept {
  const ForeignCall foreign;
  ddsi_serdata* data = nullptr;
  return SerializedData(dds_takecdr(reader, &data, 1, &info, DDS_ANY_STATE) == 1 ? data : nullptr);
}

}  // namespace

struct RosReader::Impl {
  InLink<Readers> readers;
  std::string prefix;
  std::vector<RosTopicDescription> topics{};
  std::vector<std::byte> bytes{};  ///< Buffer of one message, reused.

  std::span<const std::byte> copy(const ddsi_serdata& data) {
    bytes.resize(ddsi_serdata_size(&data));
    ddsi_serdata_to_ser(&data, 0, bytes.size(), bytes.data());
    return bytes;
  }
};

RosReader::RosReader(Link& link, const std::string& prefix) : impl_(new Impl{InLink<Readers>(link), prefix}) {
  for (std::size_t i = 0; i < kRosTopicCount; ++i) {
    const RosTopicKind& kind = kind_of(static_cast<RosTopic>(i));
    const std::string type = ros_type(kind.type->m_typename);
    impl_->topics.push_back({kind.ros_name(prefix), type, ros_definition(type), offered_qos(kind.qos)});
  }
}
RosReader::~RosReader() = default;

const std::vector<RosTopicDescription>& RosReader::topics() const noexcept {
  return impl_->topics;
}

Status RosReader::take(const std::function<Status(const RosMessage&)>& visit) {
  Impl& self = *impl_;
  const Result<Readers*> readers = self.readers.get(
      [&](const LinkMembership& membership) { return make_readers(self.readers.link(), membership, self.prefix); });
  if (!readers) {
    return Unexpected(readers.error());
  }
  for (std::size_t i = 0; *readers != nullptr && i < kRosTopicCount; ++i) {
    dds_sample_info_t info{};
    while (const SerializedData data = take_one((**readers)[i].get(), info)) {
      if (!info.valid_data) {
        continue;
      }
      if (Status visited = visit({i, info.source_timestamp, self.copy(*data)}); !visited) {
        return visited;
      }
    }
  }
  return {};
}

}  // namespace kinetrace::publishing
