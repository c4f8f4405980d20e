// Readers of topics, the counterpart of Writer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/link.hpp"
#include "link/dds_entity.hpp"
#include "transport/topic_qos.hpp"

namespace kinetrace::publishing {

/// A topic and its reader, attached to `Link::wait`.
class TopicReader {
 public:
  TopicReader() = default;
  /// Errors: kIo, with the topic and the library's message.
  [[nodiscard]] static Result<TopicReader> create(const Link& link, const LinkMembership& membership,
                                                  const dds_topic_descriptor_t& type, const std::string& topic,
                                                  const TopicQos& qos);

  [[nodiscard]] dds_entity_t get() const noexcept { return reader_.get(); }
  /// Number of matched writers.
  [[nodiscard]] std::uint32_t writers() const noexcept;

  /// Calls `visit(const Message&)` for all messages since the last call, oldest first; or `visit(const Message&,
  /// writer)`, with a number that identifies the writer. The message is valid during the call. `Message` is the C
  /// structure of the topic's type.
  template <typename Message, typename Visit>
  void take(Visit&& visit) {
    constexpr std::size_t kAtOnce = 16;
    int taken = 0;
    do {
      void* samples[kAtOnce] = {};
      dds_sample_info_t infos[kAtOnce] = {};
      {
        const ForeignCall foreign;
        taken = dds_take(reader_.get(), samples, infos, kAtOnce, kAtOnce);
      }
      for (int i = 0; i < taken; ++i) {
        if (!infos[i].valid_data) {
          continue;
        }
        const auto& message = *static_cast<const Message*>(samples[i]);
        if constexpr (std::is_invocable_v<Visit, const Message&, std::uint64_t>) {
          visit(message, std::uint64_t{infos[i].publication_handle});
        } else {
          visit(message);
        }
      }
      if (taken > 0) {
        const ForeignCall foreign;
        static_cast<void>(dds_return_loan(reader_.get(), samples, taken));
      }
    } while (taken == kAtOnce);
  }

 private:
  Entity topic_;
  Entity reader_;  // Declared after the topic, so that it is destroyed first.
};

/// An object created in a link's participant, and created again with the next one.
template <typename Made>
class InLink {
 public:
  /// `link` must outlive it.
  explicit InLink(Link& link) noexcept : link_(&link) {}

  /// The result of `make(membership)` for the current participant; null without one. Errors: those of `make`,
  /// explained; `make` is retried at the next call.
  template <typename Make>
  [[nodiscard]] Result<Made*> get(Make&& make) {
    const LinkMembership membership = link_->membership();
    if (membership.number != made_in_) {
      made_.reset();
      made_in_ = 0;
    }
    if (membership.number == 0) {
      return nullptr;
    }
    if (made_in_ == 0) {
      Result<Made> made = make(membership);
      if (!made) {
        return Unexpected(link_->explained(made.error()));
      }
      made_ = std::make_unique<Made>(std::move(*made));
      made_in_ = membership.number;
    }
    return made_.get();
  }
  /// The current object; null before `get` created it.
  [[nodiscard]] const Made* peek() const noexcept { return made_.get(); }
  [[nodiscard]] Link& link() const noexcept { return *link_; }

 private:
  Link* link_;
  std::unique_ptr<Made> made_;
  std::uint64_t made_in_ = 0;
};

}  // namespace kinetrace::publishing
