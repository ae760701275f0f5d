// SPDX-License-Identifier: GPL-2.0
// A GPIO chip for tests: 32 lines with interrupts. Output line i, below 16, is wired to line i + 16,
// where the kernel stamps what the program under test puts out. What is written to /dev/test_gpio, as
// struct level, is put on its line at its time by a timer.
#include <linux/gpio/driver.h>
#include <linux/hrtimer.h>
#include <linux/irq.h>
#include <linux/kfifo.h>
#include <linux/miscdevice.h>
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/uaccess.h>

#define LINES 32
#define LOOP 16
#define PENDING_MAX 32768

struct level {
	s64 t_ns; // CLOCK_MONOTONIC; 0: now
	u32 line, high;
};

static const char *const names[LINES] = {
	[3] = "SYNC_OUT", [4] = "HEALTH", [5] = "SYNC_IN", [6] = "LEFT_A",
	[7] = "LEFT_B", [8] = "RIGHT_A", [9] = "RIGHT_B",
	[10] = "DATA_READY", [11] = "TRIGGER",
};

static u32 levels, outputs, triggers[LINES];
static bool unmasked[LINES];
static DEFINE_SPINLOCK(lock);
static DEFINE_KFIFO(pending, struct level, PENDING_MAX);
static struct hrtimer timer;
static bool timer_runs;
static struct gpio_chip chip;
static struct platform_device *device;

// True: the line's interrupt is raised. With the lock held.
static bool set_level(unsigned int line, bool high)
{
	bool was = levels & BIT(line);

	levels = high ? levels | BIT(line) : levels & ~BIT(line);
	return was != high && unmasked[line] &&
	       triggers[line] & (high ? IRQ_TYPE_EDGE_RISING : IRQ_TYPE_EDGE_FALLING);
}

// From any context: also what other modules of the test raise.
void test_gpio_set(unsigned int line, bool high)
{
	unsigned long flags;
	bool raise;

	spin_lock_irqsave(&lock, flags);
	raise = set_level(line, high);
	spin_unlock_irqrestore(&lock, flags);
	if (raise)
		generic_handle_domain_irq_safe(chip.irq.domain, line);
}
EXPORT_SYMBOL_GPL(test_gpio_set);

static enum hrtimer_restart on_timer(struct hrtimer *t)
{
	ktime_t now = ktime_get();
	struct level next;
	unsigned long flags;
	bool more = true;

	while (more) {
		spin_lock_irqsave(&lock, flags);
		more = kfifo_peek(&pending, &next);
		timer_runs = more;
		if (more && next.t_ns > now) {
			hrtimer_set_expires(t, ns_to_ktime(next.t_ns));
			spin_unlock_irqrestore(&lock, flags);
			return HRTIMER_RESTART;
		}
		if (more)
			kfifo_skip(&pending);
		spin_unlock_irqrestore(&lock, flags);
		if (more)
			test_gpio_set(next.line, next.high);
	}
	return HRTIMER_NORESTART;
}

// ---- the chip -----------------------------------------------------------------------------------

static int get_direction(struct gpio_chip *c, unsigned int line)
{
	return outputs & BIT(line) ? GPIO_LINE_DIRECTION_OUT : GPIO_LINE_DIRECTION_IN;
}

static int direction_input(struct gpio_chip *c, unsigned int line)
{
	outputs &= ~BIT(line);
	return 0;
}

static int get(struct gpio_chip *c, unsigned int line)
{
	return !!(levels & BIT(line));
}

static void set(struct gpio_chip *c, unsigned int line, int high)
{
	test_gpio_set(line, high);
	if (line < LOOP)
		test_gpio_set(line + LOOP, high);
}

static int direction_output(struct gpio_chip *c, unsigned int line, int high)
{
	outputs |= BIT(line);
	set(c, line, high);
	return 0;
}

static void irq_mask(struct irq_data *data)
{
	unmasked[irqd_to_hwirq(data)] = false;
	gpiochip_disable_irq(&chip, irqd_to_hwirq(data));
}

static void irq_unmask(struct irq_data *data)
{
	gpiochip_enable_irq(&chip, irqd_to_hwirq(data));
	unmasked[irqd_to_hwirq(data)] = true;
}

static int irq_set_type(struct irq_data *data, unsigned int type)
{
	triggers[irqd_to_hwirq(data)] = type;
	return 0;
}

static const struct irq_chip irqs = {
	.name = "test_gpio",
	.irq_mask = irq_mask,
	.irq_unmask = irq_unmask,
	.irq_set_type = irq_set_type,
	.flags = IRQCHIP_IMMUTABLE,
	GPIOCHIP_IRQ_RESOURCE_HELPERS,
};

// ---- what a test writes -------------------------------------------------------------------------

static ssize_t feed_write(struct file *f, const char __user *from, size_t size, loff_t *at)
{
	struct level next;
	unsigned long flags;
	size_t done;
	bool full;

	if (size % sizeof(next))
		return -EINVAL;
	for (done = 0; done < size; done += sizeof(next)) {
		if (copy_from_user(&next, from + done, sizeof(next)))
			return -EFAULT;
		if (next.line >= LINES)
			return -EINVAL;
		if (!next.t_ns) {
			test_gpio_set(next.line, next.high);
			continue;
		}
		spin_lock_irqsave(&lock, flags);
		full = !kfifo_put(&pending, next);
		if (!full && !timer_runs) {
			timer_runs = true;
			hrtimer_start(&timer, ns_to_ktime(next.t_ns), HRTIMER_MODE_ABS_HARD);
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
	.name = "test_gpio",
	.fops = &feed_ops,
};

// ---- coming and going ---------------------------------------------------------------------------

static int __init test_gpio_init(void)
{
	int result;

	device = platform_device_register_simple("test_gpio", -1, NULL, 0);
	if (IS_ERR(device))
		return PTR_ERR(device);
	hrtimer_init(&timer, CLOCK_MONOTONIC, HRTIMER_MODE_ABS_HARD);
	timer.function = on_timer;
	chip = (struct gpio_chip){
		.label = "test_gpio",
		.parent = &device->dev,
		.owner = THIS_MODULE,
		.base = -1,
		.ngpio = LINES,
		.names = names,
		.get_direction = get_direction,
		.direction_input = direction_input,
		.direction_output = direction_output,
		.get = get,
		.set = set,
	};
	gpio_irq_chip_set_chip(&chip.irq, &irqs);
	chip.irq.handler = handle_simple_irq;
	chip.irq.default_type = IRQ_TYPE_NONE;
	result = gpiochip_add_data(&chip, NULL);
	if (result) {
		platform_device_unregister(device);
		return result;
	}
	return misc_register(&feed);
}

static void __exit test_gpio_exit(void)
{
	misc_deregister(&feed);
	hrtimer_cancel(&timer);
	gpiochip_remove(&chip);
	platform_device_unregister(device);
}

module_init(test_gpio_init);
module_exit(test_gpio_exit);
MODULE_DESCRIPTION("GPIO lines that a test drives and reads back");
MODULE_LICENSE("GPL");
