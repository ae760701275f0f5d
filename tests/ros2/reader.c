/* Another program on a topic: C, Cyclone DDS and ROS's public definitions of the types alone.
   Usage: reader DOMAIN SECONDS odom|tf|imu|map_points. Out: `writer TYPE USER_DATA` once, and for
   each message a line that begins with sec nanosec frame:
     odom        child, 7 numbers of the pose, 36 of its covariance, 6 of the twist, 36 of its
     tf          child, 7 numbers of the transform
     imu         first of the orientation's covariance, rates, their covariance, forces, theirs
     map_points  height width point_step row_step fields (name offset datatype count), then floats
   Ends a second after the last message. */
#include <Messages.h>
#include <dds/dds.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

static void print_header(const std_msgs_msg_dds__Header_* h) {
  printf("%d %u %s", h->stamp_.sec_, h->stamp_.nanosec_, h->frame_id_);
}

static void print_vector(const geometry_msgs_msg_dds__Vector3_* v) {
  printf(" %.17g %.17g %.17g", v->x_, v->y_, v->z_);
}

static void print_numbers(const double* numbers, int count) {
  for (int i = 0; i < count; ++i) printf(" %.17g", numbers[i]);
}

static void print_quaternion(const geometry_msgs_msg_dds__Quaternion_* q) {
  printf(" %.17g %.17g %.17g %.17g", q->x_, q->y_, q->z_, q->w_);
}

static void print_odom(const void* message) {
  const nav_msgs_msg_dds__Odometry_* const m = message;
  const geometry_msgs_msg_dds__Pose_* const pose = &m->pose_.pose_;
  print_header(&m->header_);
  printf(" %s", m->child_frame_id_);
  printf(" %.17g %.17g %.17g", pose->position_.x_, pose->position_.y_, pose->position_.z_);
  print_quaternion(&pose->orientation_);
  print_numbers(m->pose_.covariance_, 36);
  print_vector(&m->twist_.twist_.linear_);
  print_vector(&m->twist_.twist_.angular_);
  print_numbers(m->twist_.covariance_, 36);
  printf("\n");
}

static void print_tf(const void* message) {
  const tf2_msgs_msg_dds__TFMessage_* const m = message;
  for (uint32_t i = 0; i < m->transforms_._length; ++i) {
    const geometry_msgs_msg_dds__TransformStamped_* const t = &m->transforms_._buffer[i];
    print_header(&t->header_);
    printf(" %s", t->child_frame_id_);
    print_vector(&t->transform_.translation_);
    print_quaternion(&t->transform_.rotation_);
    printf("\n");
  }
}

static void print_imu(const void* message) {
  const sensor_msgs_msg_dds__Imu_* const m = message;
  print_header(&m->header_);
  print_numbers(m->orientation_covariance_, 1);
  print_vector(&m->angular_velocity_);
  print_numbers(m->angular_velocity_covariance_, 9);
  print_vector(&m->linear_acceleration_);
  print_numbers(m->linear_acceleration_covariance_, 9);
  printf("\n");
}

static void print_points(const void* message) {
  const sensor_msgs_msg_dds__PointCloud2_* const m = message;
  print_header(&m->header_);
  printf(" %u %u %u %u %u", m->height_, m->width_, m->point_step_, m->row_step_,
         m->fields_._length);
  for (uint32_t i = 0; i < m->fields_._length; ++i) {
    const sensor_msgs_msg_dds__PointField_* const f = &m->fields_._buffer[i];
    printf(" %s %u %u %u", f->name_, f->offset_, f->datatype_, f->count_);
  }
  for (uint32_t at = 0; at + 4 <= m->data_._length; at += 4) {
    float number;
    memcpy(&number, m->data_._buffer + at, sizeof number);
    printf(" %.9g", (double)number);
  }
  printf("\n");
}

static const struct {
  const char* name;
  const dds_topic_descriptor_t* type;
  void (*print)(const void*);
} kTopics[] = {{"odom", &nav_msgs_msg_dds__Odometry__desc, print_odom},
               {"tf", &tf2_msgs_msg_dds__TFMessage__desc, print_tf},
               {"imu", &sensor_msgs_msg_dds__Imu__desc, print_imu},
               {"map_points", &sensor_msgs_msg_dds__PointCloud2__desc, print_points}};

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const dds_domainid_t domain = (dds_domainid_t)atoi(argv[1]);
  const double seconds = atof(argv[2]);
  size_t kind = 0;
  while (kind < 4 && strcmp(kTopics[kind].name, argv[3]) != 0) ++kind;
  if (kind == 4 || dds_create_domain(domain, kDomain) < 0) return 1;
  const dds_entity_t participant = dds_create_participant(domain, NULL, NULL);
  char name[64];
  snprintf(name, sizeof name, "rt/%s", argv[3]);
  const dds_entity_t topic = dds_create_topic(participant, kTopics[kind].type, name, NULL, NULL);
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1000);
  /* As RViz asks for a map: whoever offers less is not matched. */
  if (kind == 3) dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
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
      if (infos[i].valid_data) kTopics[kind].print(samples[i]);
      ++heard;
    }
    silent_ms = count > 0 ? 0 : silent_ms + 10;
    if (count > 0) (void)dds_return_loan(reader, samples, count);
    dds_sleepfor(DDS_MSECS(10));
  }
  dds_delete(participant);
  return heard > 0 ? 0 : 1;
}
