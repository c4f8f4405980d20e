#include "transport/topic_qos.hpp"

namespace kinetrace::publishing {

Qos make_qos(const TopicQos& qos) {
  // KEEP_LAST writers never wait for a reader; this bound is a precaution.
  constexpr dds_duration_t kBlocksAtMost = DDS_MSECS(10);
  Qos made(dds_create_qos());
  dds_qset_reliability(made.get(), qos.best_effort ? DDS_RELIABILITY_BEST_EFFORT : DDS_RELIABILITY_RELIABLE,
                       kBlocksAtMost);
  dds_qset_history(made.get(), DDS_HISTORY_KEEP_LAST, qos.depth);
  dds_qset_durability(made.get(), qos.keeps_last ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  const dds_data_representation_id_t encoding =
      qos.encoding == Encoding::kRos ? DDS_DATA_REPRESENTATION_XCDR1 : DDS_DATA_REPRESENTATION_XCDR2;
  dds_qset_data_representation(made.get(), 1, &encoding);
  return made;
}

}  // namespace kinetrace::publishing
