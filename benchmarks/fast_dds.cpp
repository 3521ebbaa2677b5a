// Writers of serialised ROS 2 messages through eProsima's Fast DDS, as rmw_fastrtps makes them: a type that has a name and
// bytes, and is told nothing else. A library for `benchmarks.fast_dds`, which builds and loads it.

#include <cstring>
#include <vector>

#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>

using namespace eprosima::fastdds::dds;
using eprosima::fastrtps::rtps::SerializedPayload_t;

namespace {

using Bytes = std::vector<unsigned char>;  // a message, its four bytes of encapsulation included

constexpr unsigned LARGEST = 4096;  // bytes of a message

class Serialised : public TopicDataType {
 public:
  explicit Serialised(const char* name) {
    setName(name);
    m_typeSize = LARGEST;
    m_isGetKeyDefined = false;
  }

  bool serialize(void* data, SerializedPayload_t* payload) override {
    const auto& bytes = *static_cast<Bytes*>(data);
    if (bytes.size() > payload->max_size) return false;
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<unsigned>(bytes.size());
    payload->encapsulation = CDR_LE;
    return true;
  }

  bool deserialize(SerializedPayload_t*, void*) override { return false; }
  std::function<unsigned()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<unsigned>(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }
};

}  // namespace

extern "C" {

// A participant of a domain; null where it cannot be made.
void* participant(unsigned domain) {
  return DomainParticipantFactory::get_instance()->create_participant(domain, PARTICIPANT_QOS_DEFAULT);
}

// A reliable writer of a topic that keeps all; null where it cannot be made.
void* writer(void* of, const char* topic, const char* type) {
  auto* owner = static_cast<DomainParticipant*>(of);
  TypeSupport(new Serialised(type)).register_type(owner);
  auto* named = owner->create_topic(topic, type, TOPIC_QOS_DEFAULT);
  auto* publisher = owner->create_publisher(PUBLISHER_QOS_DEFAULT);
  DataWriterQos qos = DATAWRITER_QOS_DEFAULT;
  qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
  qos.history().kind = KEEP_ALL_HISTORY_QOS;
  return publisher == nullptr || named == nullptr ? nullptr : publisher->create_datawriter(named, qos);
}

// How many readers a writer has.
int readers(void* of) {
  PublicationMatchedStatus status;
  static_cast<DataWriter*>(of)->get_publication_matched_status(status);
  return status.current_count;
}

// Send a message; whether it was sent.
bool send_message(void* through, const unsigned char* data, unsigned size) {
  Bytes bytes(data, data + size);
  return static_cast<DataWriter*>(through)->write(&bytes);
}
}
