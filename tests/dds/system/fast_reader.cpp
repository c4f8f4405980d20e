// A reader of another vendor, Fast DDS: knows the messages of ROS 2 and nothing of Kinetrace. Reads all topics, and
// writes its counters to standard output, as JSON lines.
//
//   fast_reader [--address IPV4] [--peer IPV4]... [--enclave DIR] [--no-check] [--publish]
//
// --address: of the interface; default 127.0.0.1. --peer: asked for participants, beside multicast. --enclave: keys as
// ROS 2 lays them out. --no-check: counts only. --publish: also tries to write odometry.
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "fast_dds.hpp"
#include "ros_expectations.hpp"

namespace kinetrace::test {
namespace {

std::atomic<bool> is_over{false};

constexpr const char* kDetections = "rt/kinetrace/detections";

struct Options {
  std::string address = "127.0.0.1";
  std::vector<std::string> peers;
  std::string enclave;
  bool checks = true;
  bool publishes = false;
};

bool parse(const std::vector<std::string>& arguments, Options& options) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const bool has_value = i + 1 < arguments.size();
    if (arguments[i] == "--no-check") {
      options.checks = false;
    } else if (arguments[i] == "--publish") {
      options.publishes = true;
    } else if (arguments[i] == "--address" && has_value) {
      options.address = arguments[++i];
    } else if (arguments[i] == "--peer" && has_value) {
      options.peers.push_back(arguments[++i]);
    } else if (arguments[i] == "--enclave" && has_value) {
      options.enclave = arguments[++i];
    } else {
      std::cerr << "not understood: " << arguments[i] << "\n";
      return false;
    }
  }
  return true;
}

/// Collects the discovery data of other participants.
class Discovery : public DiscoveryListener {
 public:
  [[nodiscard]] nlohmann::json writers() {
    const std::lock_guard lock(mutex_);
    return writers_;
  }
  [[nodiscard]] int participants() const { return participants_; }

 private:
  void on_writer(const DiscoveredWriter& found) override {
    const std::lock_guard lock(mutex_);
    nlohmann::json& writer = writers_[found.topic];
    writer["type"] = found.type;
    writer["encodings"] = found.encodings;
    writer["reliable"] = found.reliable;
  }
  void on_participant() override { ++participants_; }

  std::mutex mutex_;
  nlohmann::json writers_ = nlohmann::json::object();
  std::atomic<int> participants_ = 0;
};

void secure(dds::DomainParticipantQos& qos, const std::string& enclave) {
  const auto set = [&qos](const std::string& name, const std::string& value) {
    qos.properties().properties().emplace_back("dds.sec." + name, value);
  };
  const auto file = [&enclave](const char* name) { return "file://" + enclave + "/" + name; };
  set("auth.plugin", "builtin.PKI-DH");
  set("auth.builtin.PKI-DH.identity_ca", file("identity_ca.cert.pem"));
  set("auth.builtin.PKI-DH.identity_certificate", file("cert.pem"));
  set("auth.builtin.PKI-DH.private_key", file("key.pem"));
  set("access.plugin", "builtin.Access-Permissions");
  set("access.builtin.Access-Permissions.permissions_ca", file("permissions_ca.cert.pem"));
  set("access.builtin.Access-Permissions.governance", file("governance.p7s"));
  set("access.builtin.Access-Permissions.permissions", file("permissions.p7s"));
  set("crypto.plugin", "builtin.AES-GCM-GMAC");
}

dds::DomainParticipantQos participant_qos(const Options& options) {
  // Ports of the first participants on a machine, domain 0.
  constexpr int kFirstPort = 7410;
  constexpr int kPortStep = 2;
  constexpr int kParticipants = 8;
  dds::DomainParticipantQos qos;
  qos.transport().use_builtin_transports = false;
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.push_back(options.address);
  qos.transport().user_transports.push_back(udp);
  for (const std::string& peer : options.peers) {
    for (int i = 0; i < kParticipants; ++i) {
      rtps::Locator_t locator;
      rtps::IPLocator::setIPv4(locator, peer);
      locator.port = static_cast<std::uint32_t>(kFirstPort + kPortStep * i);
      qos.wire_protocol().builtin.initialPeersList.push_back(locator);
    }
  }
  if (!options.peers.empty()) {  // A list replaces multicast, so that must be named too.
    rtps::Locator_t multicast;
    rtps::IPLocator::setIPv4(multicast, 239, 255, 0, 1);
    multicast.port = 7400;
    qos.wire_protocol().builtin.initialPeersList.push_back(multicast);
  }
  if (!options.enclave.empty()) {
    secure(qos, options.enclave);
  }
  return qos;
}

/// Number of elements of a message that is a list.
template <typename Message>
std::uint64_t items_in(const Message& message) {
  if constexpr (requires { message.detections(); }) {
    return message.detections().size();
  }
  return 1;
}

/// One topic: counts what comes, and keeps the first mistakes.
class TopicReader {
 public:
  template <typename PubSubType, typename Message>
  static std::unique_ptr<TopicReader> create(dds::DomainParticipant& participant, dds::Subscriber& subscriber,
                                             const std::string& name,
                                             const std::function<Mistakes(const Message&)>& mistakes_in) {
    const dds::TypeSupport type(new PubSubType());
    type.register_type(&participant);
    dds::Topic* topic = dynamic_cast<dds::Topic*>(participant.lookup_topicdescription(name));
    if (topic == nullptr) {
      topic = participant.create_topic(name, type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
    }
    dds::DataReaderQos qos;
    qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = name == "rt/tf_static" ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
    constexpr int kDepth = 64;
    qos.history().depth = kDepth;
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    std::unique_ptr<TopicReader> made(new TopicReader(name));
    made->reader_ = subscriber.create_datareader(topic, qos);
    made->take_ = [self = made.get(), mistakes_in, message = std::make_shared<Message>()](Mistakes& mistakes) {
      dds::SampleInfo info;
      if (self->reader_->take_next_sample(message.get(), &info) != kOk) {
        return Taken::kNothing;
      }
      if (!info.valid_data) {
        return Taken::kNews;
      }
      self->items_ += items_in(*message);
      for (std::string& mistake : mistakes_in ? mistakes_in(*message) : Mistakes{}) {
        mistakes.push_back(std::move(mistake));
      }
      return Taken::kSample;
    };
    return made;
  }

  void take_all() {
    constexpr std::size_t kKept = 20;
    if (reader_ == nullptr) {
      return;
    }
    for (Taken taken = take_(mistakes_); taken != Taken::kNothing; taken = take_(mistakes_)) {
      samples_ += taken == Taken::kSample ? 1 : 0;
      mistakes_.resize(std::min(mistakes_.size(), kKept));
    }
  }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::uint64_t samples() const { return samples_; }
  /// Elements of list messages; number of other messages.
  [[nodiscard]] std::uint64_t items() const { return items_; }
  [[nodiscard]] const Mistakes& mistakes() const { return mistakes_; }
  [[nodiscard]] bool is_refused() const { return reader_ == nullptr; }

 private:
  enum class Taken { kNothing, kNews, kSample };
  explicit TopicReader(std::string name) : name_(std::move(name)) {}

  std::string name_;
  dds::DataReader* reader_ = nullptr;
  std::function<Taken(Mistakes&)> take_;
  std::uint64_t samples_ = 0;
  std::uint64_t items_ = 0;
  Mistakes mistakes_;
};

using Readers = std::vector<std::unique_ptr<TopicReader>>;

Readers all_topics(dds::DomainParticipant& participant, bool checks) {
  dds::Subscriber& subscriber = *participant.create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  Readers readers;
  const auto add = [&]<typename PubSubType, typename Message>(const std::string& name,
                                                              Mistakes (*mistakes_in)(const Message&)) {
    readers.push_back(TopicReader::create<PubSubType, Message>(
        participant, subscriber, name, checks ? mistakes_in : std::function<Mistakes(const Message&)>()));
  };
  using nav_msgs::msg::Odometry;
  using tf2_msgs::msg::TFMessage;
  add.operator()<nav_msgs::msg::OdometryPubSubType, Odometry>("rt/kinetrace/odometry", mistakes_in);
  add.operator()<tf2_msgs::msg::TFMessagePubSubType, TFMessage>("rt/tf", mistakes_in_tf);
  add.operator()<tf2_msgs::msg::TFMessagePubSubType, TFMessage>("rt/tf_static", mistakes_in_static_tf);
  add.operator()<vision_msgs::msg::Detection3DArrayPubSubType, vision_msgs::msg::Detection3DArray>(kDetections,
                                                                                                   mistakes_in);
  add.operator()<visualization_msgs::msg::MarkerArrayPubSubType, visualization_msgs::msg::MarkerArray>(
      "rt/kinetrace/markers", mistakes_in);
  add.operator()<geometry_msgs::msg::PoseArrayPubSubType, geometry_msgs::msg::PoseArray>("rt/kinetrace/trajectories",
                                                                                         mistakes_in);
  add.operator()<sensor_msgs::msg::PointCloud2PubSubType, sensor_msgs::msg::PointCloud2>("rt/kinetrace/points",
                                                                                         mistakes_in);
  add.operator()<diagnostic_msgs::msg::DiagnosticArrayPubSubType, diagnostic_msgs::msg::DiagnosticArray>(
      "rt/diagnostics", mistakes_in);
  return readers;
}

bool may_write_odometry(dds::DomainParticipant& participant) {
  dds::Publisher* publisher = participant.create_publisher(dds::PUBLISHER_QOS_DEFAULT);
  auto* topic = dynamic_cast<dds::Topic*>(participant.lookup_topicdescription("rt/kinetrace/odometry"));
  return publisher->create_datawriter(topic, dds::DATAWRITER_QOS_DEFAULT) != nullptr;
}

void print(const Readers& readers, Discovery& discovery) {
  nlohmann::json line{{"participants", discovery.participants()}, {"writers", discovery.writers()}};
  std::uint64_t total = 0;
  line["samples"] = nlohmann::json::object();
  line["mistakes"] = nlohmann::json::array();
  line["refused"] = nlohmann::json::array();
  for (const std::unique_ptr<TopicReader>& reader : readers) {
    line["samples"][reader->name()] = reader->samples();
    total += reader->samples();
    if (reader->name() == kDetections) {
      line["detections"] = reader->items();
    }
    if (reader->is_refused()) {
      line["refused"].push_back(reader->name());
    }
    for (const std::string& mistake : reader->mistakes()) {
      line["mistakes"].push_back(reader->name() + ": " + mistake);
    }
  }
  line["total"] = total;
  std::cout << line.dump() << std::endl;
}

int run(const Options& options) {
  Discovery discovery;
  dds::DomainParticipant* participant = dds::DomainParticipantFactory::get_instance()->create_participant(
      0, participant_qos(options), &discovery, dds::StatusMask::none());
  if (participant == nullptr) {
    std::cerr << "participant refused" << std::endl;
    return 1;
  }
  const Readers readers = all_topics(*participant, options.checks);
  if (options.publishes && may_write_odometry(*participant)) {
    std::cerr << "may write odometry" << std::endl;
  }
  constexpr auto kPrintEvery = std::chrono::milliseconds(100);
  constexpr auto kPause = std::chrono::milliseconds(5);
  auto next_print = std::chrono::steady_clock::now();
  while (!is_over) {
    for (const std::unique_ptr<TopicReader>& reader : readers) {
      reader->take_all();
    }
    if (std::chrono::steady_clock::now() >= next_print) {
      next_print += kPrintEvery;
      print(readers, discovery);
    }
    std::this_thread::sleep_for(kPause);
  }
  print(readers, discovery);
  participant->delete_contained_entities();
  dds::DomainParticipantFactory::get_instance()->delete_participant(participant);
  return 0;
}

}  // namespace
}  // namespace kinetrace::test

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape): what is thrown ends a test as it should.
  using namespace kinetrace::test;
  std::signal(SIGTERM, [](int) { is_over = true; });
  Options options;
  constexpr int kUsage = 64;
  return parse({argv + 1, argv + argc}, options) ? run(options) : kUsage;
}
