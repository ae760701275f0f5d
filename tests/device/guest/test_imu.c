// SPDX-License-Identifier: GPL-2.0
// An IMU for tests: an I2C bus with a model of the MPU-6500 (registers, FIFO, data-ready interrupt)
// under the kernel's own inv-mpu6050-i2c; or, with icm20602=1, of the ICM-20602, which no driver of
// the kernel has and whose interrupt is a line of test_gpio.c. What is written to /dev/test_imu, as
// struct sample, is measured at its time by a timer, as a chip would: then the interrupt comes. A
// sample with `fault` is none, but what goes wrong then.
#include <linux/hrtimer.h>
#include <linux/i2c.h>
#include <linux/interrupt.h>
#include <linux/irq.h>
#include <linux/kfifo.h>
#include <linux/miscdevice.h>
#include <linux/module.h>
#include <linux/uaccess.h>

#define ADDRESS 0x68
#define FIFO_BYTES 1024
#define FIFO_BYTES_ICM 1008
#define PENDING_MAX 8192
#define DATA_READY 10 // line of test_gpio.c

static bool icm20602;
module_param(icm20602, bool, 0444);

void test_gpio_set(unsigned int line, bool high);

// Registers of the MPU-6500 that the model gives a meaning (register map, revision 2.1).
enum {
	FIFO_ENABLE = 0x23, // bit 3: force, bits 6 to 4: rate x y z, bit 7: temperature
	INT_ENABLE = 0x38,
	INT_STATUS = 0x3a,
	MEASURED = 0x3b, // force x y z, temperature, rate x y z: big-endian
	USER_CONTROL = 0x6a, // bit 6: FIFO on, bit 2: FIFO reset
	POWER_1 = 0x6b, // bit 7: reset, bit 6: asleep
	FIFO_COUNT_HIGH = 0x72,
	FIFO_COUNT_LOW = 0x73,
	FIFO_DATA = 0x74,
	WHO_AM_I = 0x75,
};

struct sample {
	s64 t_ns; // CLOCK_MONOTONIC
	s16 force[3], temperature, rate[3], fault;
};

// What goes wrong, from its time on.
enum {
	FAULT_NONE,
	FAULT_BUS, // no transfer is answered ...
	FAULT_BUS_GOOD, // ... until now
	FAULT_SILENT, // samples are taken, but no interrupt comes ...
	FAULT_SILENT_GOOD, // ... until now
	FAULT_RESET, // as by a brown-out
};

static u8 registers[128], address;
static u8 fifo[FIFO_BYTES];
static int fifo_head, fifo_count;
static DEFINE_SPINLOCK(lock);
static DEFINE_KFIFO(pending, struct sample, PENDING_MAX);
static struct hrtimer timer;
static bool timer_runs, bus_dead, silent;
static int irq;
static struct i2c_client *client;

// ---- the chip -----------------------------------------------------------------------------------

static void reset_chip(void)
{
	memset(registers, 0, sizeof(registers));
	registers[POWER_1] = 0x40;
	registers[WHO_AM_I] = icm20602 ? 0x12 : 0x70;
	fifo_head = fifo_count = 0;
}

static void push(u8 byte)
{
	if (fifo_count == FIFO_BYTES) { // the oldest goes, and the overflow is told
		fifo_head = (fifo_head + 1) % FIFO_BYTES;
		fifo_count--;
		registers[INT_STATUS] |= 0x10;
	}
	fifo[(fifo_head + fifo_count++) % FIFO_BYTES] = byte;
}

static bool goes_to_fifo(int byte)
{
	u8 enabled = registers[FIFO_ENABLE];

	if (icm20602) // bit 3: force, bit 4: rate; the temperature with either
		return (enabled & 0x18) == 0x18;
	if (byte < 6)
		return enabled & 0x08;
	if (byte < 8)
		return enabled & 0x80;
	return enabled & (0x40 >> ((byte - 8) / 2));
}

// True: the interrupt is raised. With the lock held.
static bool measure(const struct sample *s)
{
	const s16 values[7] = { s->force[0], s->force[1], s->force[2], s->temperature,
				s->rate[0], s->rate[1], s->rate[2] };
	bool full;
	int i;

	if (registers[POWER_1] & 0x40)
		return false;
	for (i = 0; i < 14; i++)
		registers[MEASURED + i] = (u16)values[i / 2] >> (i % 2 ? 0 : 8);
	// The ICM-20602 stops when it is full, as it is set up.
	full = icm20602 && fifo_count + 14 > FIFO_BYTES_ICM;
	for (i = 0; i < 14 && registers[USER_CONTROL] & 0x40 && !full; i++)
		if (goes_to_fifo(i))
			push(registers[MEASURED + i]);
	registers[INT_STATUS] |= 1;
	return registers[INT_ENABLE] & 1;
}

static void fail(int fault)
{
	if (fault == FAULT_BUS || fault == FAULT_BUS_GOOD)
		bus_dead = fault == FAULT_BUS;
	if (fault == FAULT_SILENT || fault == FAULT_SILENT_GOOD)
		silent = fault == FAULT_SILENT;
	if (fault == FAULT_RESET)
		reset_chip();
}

static void interrupt(void)
{
	if (!icm20602) {
		generic_handle_irq(irq);
		return;
	}
	test_gpio_set(DATA_READY, true);
	test_gpio_set(DATA_READY, false);
}

static enum hrtimer_restart on_timer(struct hrtimer *t)
{
	struct sample s;
	bool raise = false, more;
	unsigned long flags;

	spin_lock_irqsave(&lock, flags);
	if (kfifo_get(&pending, &s)) {
		if (s.fault)
			fail(s.fault);
		else
			raise = measure(&s) && !silent;
	}
	more = kfifo_peek(&pending, &s);
	if (more)
		hrtimer_set_expires(t, ns_to_ktime(s.t_ns));
	timer_runs = more;
	spin_unlock_irqrestore(&lock, flags);
	if (raise)
		interrupt();
	return more ? HRTIMER_RESTART : HRTIMER_NORESTART;
}

// ---- the bus ------------------------------------------------------------------------------------

static u8 read_register(u8 at)
{
	u8 value = registers[at & 127];

	switch (at) {
	case INT_STATUS:
		registers[INT_STATUS] = 0;
		break;
	case FIFO_COUNT_HIGH:
		return fifo_count >> 8;
	case FIFO_COUNT_LOW:
		return fifo_count;
	case FIFO_DATA:
		if (!fifo_count)
			return 0xff;
		value = fifo[fifo_head];
		fifo_head = (fifo_head + 1) % FIFO_BYTES;
		fifo_count--;
		break;
	}
	return value;
}

static void write_register(u8 at, u8 value)
{
	if (at == POWER_1 && value & 0x80) {
		reset_chip();
		return;
	}
	if (at == USER_CONTROL && value & 0x04) {
		fifo_head = fifo_count = 0;
		value &= ~0x04;
	}
	if (at != WHO_AM_I)
		registers[at & 127] = value;
}

static void transfer_message(struct i2c_msg *m)
{
	int i;

	for (i = 0; i < m->len; i++) {
		if (m->flags & I2C_M_RD) {
			m->buf[i] = read_register(address);
		} else if (i == 0) {
			address = m->buf[0];
			continue;
		} else {
			write_register(address, m->buf[i]);
		}
		if (address != FIFO_DATA)
			address++;
	}
}

static int transfer(struct i2c_adapter *adapter, struct i2c_msg *messages, int count)
{
	unsigned long flags;
	int i;

	for (i = 0; i < count; i++) {
		if (messages[i].addr != ADDRESS || bus_dead)
			return -ENXIO;
		spin_lock_irqsave(&lock, flags);
		transfer_message(&messages[i]);
		spin_unlock_irqrestore(&lock, flags);
	}
	return count;
}

static u32 functionality(struct i2c_adapter *adapter)
{
	return I2C_FUNC_I2C | I2C_FUNC_SMBUS_EMUL;
}

static const struct i2c_algorithm algorithm = {
	.master_xfer = transfer,
	.functionality = functionality,
};
static struct i2c_adapter bus = { .owner = THIS_MODULE, .algo = &algorithm, .name = "test_imu" };

// ---- what a test writes -------------------------------------------------------------------------

static ssize_t feed_write(struct file *f, const char __user *from, size_t size, loff_t *at)
{
	struct sample s;
	unsigned long flags;
	size_t done;
	bool full;

	if (size % sizeof(s))
		return -EINVAL;
	for (done = 0; done < size; done += sizeof(s)) {
		if (copy_from_user(&s, from + done, sizeof(s)))
			return -EFAULT;
		spin_lock_irqsave(&lock, flags);
		full = !kfifo_put(&pending, s);
		if (!full && !timer_runs) {
			timer_runs = true;
			hrtimer_start(&timer, ns_to_ktime(s.t_ns), HRTIMER_MODE_ABS_HARD);
		}
		spin_unlock_irqrestore(&lock, flags);
		if (full)
			return done ? done : -ENOSPC;
	}
	return done;
}

static const struct file_operations feed_ops = { .owner = THIS_MODULE, .write = feed_write };
static struct miscdevice feed = {
	.minor = MISC_DYNAMIC_MINOR,
	.name = "test_imu",
	.fops = &feed_ops,
};

// ---- coming and going ---------------------------------------------------------------------------

static int __init test_imu_init(void)
{
	struct i2c_board_info chip = { .type = "mpu6500", .addr = ADDRESS };
	int result;

	reset_chip();
	hrtimer_init(&timer, CLOCK_MONOTONIC, HRTIMER_MODE_ABS_HARD);
	timer.function = on_timer;
	irq = irq_alloc_desc(0);
	if (irq < 0)
		return irq;
	irq_set_chip_and_handler_name(irq, &dummy_irq_chip, handle_simple_irq, "test_imu");
	irq_modify_status(irq, IRQ_NOREQUEST | IRQ_NOAUTOEN, IRQ_NOPROBE);
	result = i2c_add_adapter(&bus);
	if (result)
		return result;
	chip.irq = irq;
	if (!icm20602)
		client = i2c_new_client_device(&bus, &chip);
	if (IS_ERR(client)) {
		i2c_del_adapter(&bus);
		return PTR_ERR(client);
	}
	return misc_register(&feed);
}

static void __exit test_imu_exit(void)
{
	misc_deregister(&feed);
	hrtimer_cancel(&timer);
	if (client)
		i2c_unregister_device(client);
	i2c_del_adapter(&bus);
	irq_free_descs(irq, 1);
}

module_init(test_imu_init);
module_exit(test_imu_exit);
MODULE_DESCRIPTION("An MPU-6500 that measures what a test writes");
MODULE_LICENSE("GPL");
