// SPDX-License-Identifier: GPL-2.0
// Cameras for tests: each is a plain V4L2 capture device (GREY, MMAP; with mplane=1 of the
// multi-planar interface alone, as rkisp1), and shows what is written to
// /dev/test_cameraN: a struct shot and the pixels. As a sensor does, a camera without a free buffer
// loses the image, and its sequence goes on. A struct shot alone pulls the camera, plugs it in, or
// makes it stall until its stream has been started `skip` times.
// With exposure=N it has controls of exposure and gain, which begin so and are true of the second
// image after they were set: what is written is what 4 ms and gain 16 show of the scene. From image
// dim_at on it has 30 % of its light; at image meddle_at the exposure is set as another program would.
// The kernel's log then has "test_cameraN exposed STAMP for US" of each image.
#include <linux/miscdevice.h>
#include <linux/module.h>
#include <linux/uaccess.h>
#include <media/v4l2-ctrls.h>
#include <media/v4l2-device.h>
#include <media/v4l2-ioctl.h>
#include <media/videobuf2-v4l2.h>
#include <media/videobuf2-vmalloc.h>

#define CAMERAS_MAX 4

static int cameras = 2, width = 752, height = 480;
static int exposure, dim_at, meddle_at;
static bool mplane;
module_param(mplane, bool, 0444);
module_param(exposure, int, 0444); // 100 us; 0: no controls
module_param(dim_at, int, 0444);
module_param(meddle_at, int, 0444);
module_param(cameras, int, 0444);
module_param(width, int, 0444);
module_param(height, int, 0444);

struct shot {
	u64 stamp_ns; // start of exposure, CLOCK_MONOTONIC
	u32 skip;     // images that the sensor lost before this one
	u32 what;
};
enum { SHOT_GOOD, SHOT_BAD /* V4L2_BUF_FLAG_ERROR */, CAMERA_PULL, CAMERA_PLUG, CAMERA_STALL };

struct buffer {
	struct vb2_v4l2_buffer vb;
	struct list_head list;
};

struct camera {
	struct v4l2_device v4l2;
	struct video_device *node; // NULL: pulled; a new one each time it is plugged in
	struct vb2_queue queue;
	struct mutex lock, shooting;
	spinlock_t list_lock;
	struct list_head free;
	struct miscdevice feed;
	char name[24];
	u32 sequence;
	bool streaming;
	u32 stalls;
	struct v4l2_ctrl_handler controls;
	struct v4l2_ctrl *exposure, *gain;
	u32 latched, product; // exposure, and that by gain, of the next image
	int shots;
};
static struct camera *all[CAMERAS_MAX];

// ---- buffers ------------------------------------------------------------------------------------

static int queue_setup(struct vb2_queue *q, unsigned int *buffers, unsigned int *planes,
		       unsigned int sizes[], struct device *devices[])
{
	if (*planes)
		return sizes[0] < width * height ? -EINVAL : 0;
	*planes = 1;
	sizes[0] = width * height;
	return 0;
}

static int buffer_prepare(struct vb2_buffer *b)
{
	if (vb2_plane_size(b, 0) < width * height)
		return -EINVAL;
	vb2_set_plane_payload(b, 0, width * height);
	return 0;
}

static void buffer_queue(struct vb2_buffer *b)
{
	struct camera *c = vb2_get_drv_priv(b->vb2_queue);
	struct buffer *ours = container_of(to_vb2_v4l2_buffer(b), struct buffer, vb);
	unsigned long flags;

	spin_lock_irqsave(&c->list_lock, flags);
	list_add_tail(&ours->list, &c->free);
	spin_unlock_irqrestore(&c->list_lock, flags);
}

static struct buffer *take_free(struct camera *c)
{
	struct buffer *b = NULL;
	unsigned long flags;

	spin_lock_irqsave(&c->list_lock, flags);
	if (c->streaming && !list_empty(&c->free)) {
		b = list_first_entry(&c->free, struct buffer, list);
		list_del(&b->list);
	}
	spin_unlock_irqrestore(&c->list_lock, flags);
	return b;
}

static int start_streaming(struct vb2_queue *q, unsigned int count)
{
	struct camera *c = vb2_get_drv_priv(q);

	c->sequence = 0;
	c->stalls -= c->stalls > 0;
	c->streaming = true;
	return 0;
}

static void stop_streaming(struct vb2_queue *q)
{
	struct camera *c = vb2_get_drv_priv(q);
	struct buffer *b;

	mutex_lock(&c->shooting);
	while ((b = take_free(c)))
		vb2_buffer_done(&b->vb.vb2_buf, VB2_BUF_STATE_ERROR);
	c->streaming = false;
	mutex_unlock(&c->shooting);
}

static const struct vb2_ops queue_ops = {
	.queue_setup = queue_setup,
	.buf_prepare = buffer_prepare,
	.buf_queue = buffer_queue,
	.start_streaming = start_streaming,
	.stop_streaming = stop_streaming,
	.wait_prepare = vb2_ops_wait_prepare,
	.wait_finish = vb2_ops_wait_finish,
};

// ---- exposure -----------------------------------------------------------------------------------

#define GAIN_ONE 16
#define FULL (40ull * GAIN_ONE * 100)

static int set_control(struct v4l2_ctrl *control)
{
	return 0;
}
static const struct v4l2_ctrl_ops control_ops = { .s_ctrl = set_control };

static int add_controls(struct camera *c)
{
	v4l2_ctrl_handler_init(&c->controls, 2);
	c->exposure = v4l2_ctrl_new_std(&c->controls, &control_ops, V4L2_CID_EXPOSURE_ABSOLUTE, 1,
					2000, 1, exposure);
	c->gain = v4l2_ctrl_new_std(&c->controls, &control_ops, V4L2_CID_GAIN, GAIN_ONE,
				    16 * GAIN_ONE, 1, GAIN_ONE);
	c->v4l2.ctrl_handler = &c->controls;
	c->latched = exposure;
	c->product = exposure * GAIN_ONE;
	return c->controls.error;
}

// The sensor latches its registers when an image begins: the next one has them.
static void expose(struct camera *c, u64 stamp_ns, u8 *pixels, size_t count)
{
	u32 light = dim_at && c->shots >= dim_at ? 30 : 100;
	u8 seen[256];
	size_t i;

	for (i = 0; i < 256; i++)
		seen[i] = min_t(u64, div64_u64(i * (u64)c->product * light, FULL), 255);
	for (i = 0; i < count; i++)
		pixels[i] = seen[pixels[i]];
	printk(KERN_DEBUG "%s exposed %llu for %u\n", c->name, stamp_ns, 100 * c->latched);
	c->latched = v4l2_ctrl_g_ctrl(c->exposure);
	c->product = c->latched * v4l2_ctrl_g_ctrl(c->gain);
	c->shots++;
	if (meddle_at && c->shots == meddle_at)
		v4l2_ctrl_s_ctrl(c->exposure, 3);
}

// ---- what a test writes -------------------------------------------------------------------------

static int plug(struct camera *c);

static int do_without_image(struct camera *c, u32 what, u32 starts)
{
	if (what == CAMERA_STALL) {
		c->stalls = starts;
		return 0;
	}
	if (what == CAMERA_PLUG && !c->node)
		return plug(c);
	if (what != CAMERA_PULL || !c->node)
		return -EINVAL;
	vb2_video_unregister_device(c->node);
	c->node = NULL;
	return 0;
}

static ssize_t feed_write(struct file *f, const char __user *from, size_t size, loff_t *at)
{
	struct camera *c = container_of(f->private_data, struct camera, feed);
	struct shot shot;
	struct buffer *b;
	ssize_t result = size;

	if (size < sizeof(shot) || copy_from_user(&shot, from, sizeof(shot)))
		return -EINVAL;
	if (size == sizeof(shot))
		return do_without_image(c, shot.what, shot.skip) ?: size;
	if (size != sizeof(shot) + width * height)
		return -EINVAL;
	mutex_lock(&c->shooting);
	b = c->stalls ? NULL : take_free(c);
	c->sequence += shot.skip;
	if (b) {
		void *pixels = vb2_plane_vaddr(&b->vb.vb2_buf, 0);
		bool bad = copy_from_user(pixels, from + sizeof(shot), width * height) ||
			   shot.what == SHOT_BAD;

		if (exposure)
			expose(c, shot.stamp_ns, pixels, width * height);
		b->vb.vb2_buf.timestamp = shot.stamp_ns;
		b->vb.sequence = c->sequence++;
		b->vb.field = V4L2_FIELD_NONE;
		vb2_buffer_done(&b->vb.vb2_buf, bad ? VB2_BUF_STATE_ERROR : VB2_BUF_STATE_DONE);
	} else {
		c->sequence++;
		result = -ENOBUFS;
	}
	mutex_unlock(&c->shooting);
	return result;
}

static const struct file_operations feed_ops = { .owner = THIS_MODULE, .write = feed_write };

// ---- what V4L2 asks -----------------------------------------------------------------------------

static int querycap(struct file *f, void *p, struct v4l2_capability *about)
{
	struct camera *c = video_drvdata(f);

	strscpy(about->driver, "test_camera", sizeof(about->driver));
	strscpy(about->card, c->name, sizeof(about->card));
	snprintf(about->bus_info, sizeof(about->bus_info), "platform:%s", c->name);
	return 0;
}

static int enum_format(struct file *f, void *p, struct v4l2_fmtdesc *d)
{
	if (d->index)
		return -EINVAL;
	d->pixelformat = V4L2_PIX_FMT_GREY;
	return 0;
}

static int format(struct file *f, void *p, struct v4l2_format *v)
{
	v->fmt.pix = (struct v4l2_pix_format){
		.width = width,
		.height = height,
		.pixelformat = V4L2_PIX_FMT_GREY,
		.field = V4L2_FIELD_NONE,
		.bytesperline = width,
		.sizeimage = width * height,
		.colorspace = V4L2_COLORSPACE_RAW,
	};
	return 0;
}

static int set_format(struct file *f, void *p, struct v4l2_format *v)
{
	struct camera *c = video_drvdata(f);

	return vb2_is_busy(&c->queue) ? -EBUSY : format(f, p, v);
}

static int format_mplane(struct file *f, void *p, struct v4l2_format *v)
{
	v->fmt.pix_mp = (struct v4l2_pix_format_mplane){
		.width = width,
		.height = height,
		.pixelformat = V4L2_PIX_FMT_GREY,
		.field = V4L2_FIELD_NONE,
		.colorspace = V4L2_COLORSPACE_RAW,
		.num_planes = 1,
		.plane_fmt[0] = { .bytesperline = width, .sizeimage = width * height },
	};
	return 0;
}

static int set_format_mplane(struct file *f, void *p, struct v4l2_format *v)
{
	struct camera *c = video_drvdata(f);

	return vb2_is_busy(&c->queue) ? -EBUSY : format_mplane(f, p, v);
}

static int enum_input(struct file *f, void *p, struct v4l2_input *i)
{
	if (i->index)
		return -EINVAL;
	i->type = V4L2_INPUT_TYPE_CAMERA;
	strscpy(i->name, "test", sizeof(i->name));
	return 0;
}

static int get_input(struct file *f, void *p, unsigned int *i)
{
	*i = 0;
	return 0;
}

static int set_input(struct file *f, void *p, unsigned int i)
{
	return i ? -EINVAL : 0;
}

static const struct v4l2_ioctl_ops ioctls = {
	.vidioc_querycap = querycap,
	.vidioc_enum_fmt_vid_cap = enum_format,
	.vidioc_g_fmt_vid_cap = format,
	.vidioc_try_fmt_vid_cap = format,
	.vidioc_s_fmt_vid_cap = set_format,
	.vidioc_g_fmt_vid_cap_mplane = format_mplane,
	.vidioc_try_fmt_vid_cap_mplane = format_mplane,
	.vidioc_s_fmt_vid_cap_mplane = set_format_mplane,
	.vidioc_enum_input = enum_input,
	.vidioc_g_input = get_input,
	.vidioc_s_input = set_input,
	.vidioc_reqbufs = vb2_ioctl_reqbufs,
	.vidioc_querybuf = vb2_ioctl_querybuf,
	.vidioc_qbuf = vb2_ioctl_qbuf,
	.vidioc_dqbuf = vb2_ioctl_dqbuf,
	.vidioc_streamon = vb2_ioctl_streamon,
	.vidioc_streamoff = vb2_ioctl_streamoff,
};

static const struct v4l2_file_operations node_ops = {
	.owner = THIS_MODULE,
	.open = v4l2_fh_open,
	.release = vb2_fop_release,
	.unlocked_ioctl = video_ioctl2,
	.mmap = vb2_fop_mmap,
	.poll = vb2_fop_poll,
};

// ---- coming and going ---------------------------------------------------------------------------

static int plug(struct camera *c)
{
	struct video_device *node = video_device_alloc();

	if (!node)
		return -ENOMEM;
	strscpy(node->name, c->name, sizeof(node->name));
	node->fops = &node_ops;
	node->ioctl_ops = &ioctls;
	node->v4l2_dev = &c->v4l2;
	node->queue = &c->queue;
	node->lock = &c->lock;
	node->release = video_device_release; // when the last program has closed it
	node->device_caps = V4L2_CAP_STREAMING |
		(mplane ? V4L2_CAP_VIDEO_CAPTURE_MPLANE : V4L2_CAP_VIDEO_CAPTURE);
	video_set_drvdata(node, c);
	c->node = node;
	return video_register_device(node, VFL_TYPE_VIDEO, -1);
}

static int add_camera(int i)
{
	struct camera *c = all[i] = kzalloc(sizeof(*c), GFP_KERNEL);
	int result;

	if (!c)
		return -ENOMEM;
	snprintf(c->name, sizeof(c->name), "test_camera%d", i);
	strscpy(c->v4l2.name, c->name, sizeof(c->v4l2.name));
	mutex_init(&c->lock);
	mutex_init(&c->shooting);
	spin_lock_init(&c->list_lock);
	INIT_LIST_HEAD(&c->free);
	result = v4l2_device_register(NULL, &c->v4l2);
	if (result)
		return result;
	result = exposure ? add_controls(c) : 0;
	if (result)
		return result;
	c->queue = (struct vb2_queue){
		.type = mplane ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE,
		.io_modes = VB2_MMAP,
		.drv_priv = c,
		.ops = &queue_ops,
		.mem_ops = &vb2_vmalloc_memops,
		.buf_struct_size = sizeof(struct buffer),
		.timestamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE,
		.lock = &c->lock,
	};
	result = vb2_queue_init(&c->queue);
	if (result)
		return result;
	result = plug(c);
	if (result)
		return result;
	c->feed = (struct miscdevice){
		.minor = MISC_DYNAMIC_MINOR,
		.name = c->name,
		.fops = &feed_ops,
	};
	return misc_register(&c->feed);
}

static int __init test_camera_init(void)
{
	int i, result = 0;

	cameras = clamp(cameras, 1, CAMERAS_MAX);
	for (i = 0; i < cameras && !result; i++)
		result = add_camera(i);
	return result;
}

// Not while a node is open.
static void __exit test_camera_exit(void)
{
	int i;

	for (i = 0; i < cameras && all[i]; i++) {
		misc_deregister(&all[i]->feed);
		if (all[i]->node)
			video_unregister_device(all[i]->node);
		if (exposure)
			v4l2_ctrl_handler_free(&all[i]->controls);
		v4l2_device_unregister(&all[i]->v4l2);
		kfree(all[i]);
	}
}

module_init(test_camera_init);
module_exit(test_camera_exit);
MODULE_DESCRIPTION("Cameras that show what a test writes");
MODULE_LICENSE("GPL");
