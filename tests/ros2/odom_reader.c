/* Another program on the topic: C, Cyclone DDS and ROS's public definition of the type alone.
   Usage: odom_reader DOMAIN SECONDS. Out: `writer TYPE USER_DATA` once, `reading` when it listens,
   and for each message a line: sec nanosec frame child, 7 numbers of the pose, 36 of its
   covariance, 6 of the twist, 36 of its covariance. Ends a second after the last message. */
#include <Odometry.h>
#include <dds/dds.h>
#include <stdio.h>
#include <stdlib.h>

static const char kDomain[] =
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface address=\"127.0.0.1\"/>"
    "</Interfaces><AllowMulticast>false</AllowMulticast></General><Discovery>"
    "<ParticipantIndex>auto</ParticipantIndex><Peers><Peer Address=\"localhost\"/></Peers>"
    "</Discovery></Domain></CycloneDDS>";

static void print_writer(dds_entity_t reader) {
  dds_instance_handle_t writer;
  if (dds_get_matched_publications(reader, &writer, 1) < 1) return;
  dds_builtintopic_endpoint_t* const end = dds_get_matched_publication_data(reader, writer);
  void* data = NULL;
  size_t size = 0;
  dds_qget_userdata(end->qos, &data, &size);
  printf("writer %s %.*s\n", end->type_name, (int)size, (const char*)data);
  dds_free(data);
  dds_builtintopic_free_endpoint(end);
}

static void print(const nav_msgs_msg_dds__Odometry_* m) {
  const geometry_msgs_msg_dds__Pose_* const pose = &m->pose_.pose_;
  const geometry_msgs_msg_dds__Twist_* const twist = &m->twist_.twist_;
  printf("%d %u %s %s", m->header_.stamp_.sec_, m->header_.stamp_.nanosec_, m->header_.frame_id_,
         m->child_frame_id_);
  printf(" %.17g %.17g %.17g", pose->position_.x_, pose->position_.y_, pose->position_.z_);
  printf(" %.17g %.17g %.17g %.17g", pose->orientation_.x_, pose->orientation_.y_,
         pose->orientation_.z_, pose->orientation_.w_);
  for (int i = 0; i < 36; ++i) printf(" %.17g", m->pose_.covariance_[i]);
  printf(" %.17g %.17g %.17g", twist->linear_.x_, twist->linear_.y_, twist->linear_.z_);
  printf(" %.17g %.17g %.17g", twist->angular_.x_, twist->angular_.y_, twist->angular_.z_);
  for (int i = 0; i < 36; ++i) printf(" %.17g", m->twist_.covariance_[i]);
  printf("\n");
}

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const dds_domainid_t domain = (dds_domainid_t)atoi(argv[1]);
  const double seconds = atof(argv[2]);
  if (dds_create_domain(domain, kDomain) < 0) return 1;
  const dds_entity_t participant = dds_create_participant(domain, NULL, NULL);
  const dds_entity_t topic = dds_create_topic(participant, &nav_msgs_msg_dds__Odometry__desc,
                                              "rt/odom", NULL, NULL);
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1000);
  const dds_entity_t reader = dds_create_reader(participant, topic, qos, NULL);
  dds_delete_qos(qos);
  if (reader < 0) return 1;
  int silent_ms = 0, heard = 0;
  for (int ms = 0; ms < seconds * 1000 && (heard == 0 || silent_ms < 1000); ms += 10) {
    void* samples[64] = {NULL};
    dds_sample_info_t infos[64];
    const int count = dds_take(reader, samples, infos, 64, 64);
    if (count > 0 && heard == 0) print_writer(reader);
    for (int i = 0; i < count; ++i) {
      if (infos[i].valid_data) print((const nav_msgs_msg_dds__Odometry_*)samples[i]);
      ++heard;
    }
    silent_ms = count > 0 ? 0 : silent_ms + 10;
    if (count > 0) (void)dds_return_loan(reader, samples, count);
    dds_sleepfor(DDS_MSECS(10));
  }
  dds_delete(participant);
  return heard > 0 ? 0 : 1;
}
