#include "kinetrace/publishing/result_reader.hpp"

#include <array>
#include <memory>
#include <utility>

#include "kinetrace.h"
#include "kinetrace/publishing/topics.hpp"
#include "native/native_samples.hpp"
#include "transport/topic_reader.hpp"

namespace kinetrace::publishing {
namespace {

struct Readers {
  TopicReader camera;
  TopicReader objects;
  TopicReader health;
  TopicReader calibration;
};

Result<Readers> make_readers(const Link& link, const LinkMembership& membership) {
  // Deep enough to buffer messages while a terminal is slow.
  const TopicQos some{.depth = 64};
  const TopicQos kept{.depth = 1, .keeps_last = true};
  struct Spec {
    TopicReader Readers::*reader;
    const dds_topic_descriptor_t& type;
    const char* topic;
    TopicQos qos;
  };
  const std::array<Spec, 4> specs{{{&Readers::camera, kinetrace_CameraPose_desc, topics::kCameraPose, some},
                                   {&Readers::objects, kinetrace_TrackedObjects_desc, topics::kObjects, some},
                                   {&Readers::health, kinetrace_Health_desc, topics::kHealth, kept},
                                   {&Readers::calibration, kinetrace_Calibration_desc, topics::kCalibration, kept}}};
  Readers made;
  for (const Spec& spec : specs) {
    Result<TopicReader> reader = TopicReader::create(link, membership, spec.type, spec.topic, spec.qos);
    if (!reader) {
      return Unexpected(reader.error());
    }
    made.*spec.reader = std::move(*reader);
  }
  return made;
}

}  // namespace

struct ResultReader::Impl {
  InLink<Readers> readers;
};

ResultReader::ResultReader(Link& link) : impl_(new Impl{InLink<Readers>(link)}) {}
ResultReader::~ResultReader() = default;

Status ResultReader::take(ResultListener& listener) {
  const Result<Readers*> readers = impl_->readers.get(
      [&](const LinkMembership& membership) { return make_readers(impl_->readers.link(), membership); });
  if (!readers) {
    return Unexpected(readers.error());
  }
  if (*readers == nullptr) {
    return {};
  }
  Readers& all = **readers;
  all.calibration.take<kinetrace_Calibration>([&](const auto& message) { tell(message, listener); });
  all.health.take<kinetrace_Health>([&](const auto& message) { tell(message, listener); });
  all.camera.take<kinetrace_CameraPose>([&](const auto& message) { tell(message, listener); });
  all.objects.take<kinetrace_TrackedObjects>([&](const auto& message) { tell(message, listener); });
  return {};
}

}  // namespace kinetrace::publishing
