# Rockchip RK3399: 4 Cortex-A53, 2 Cortex-A72.
include board/bare/bare.mk
