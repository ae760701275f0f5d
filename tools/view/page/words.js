// Words for what a pose says of itself in short (docs/health.md).

const kReasons = {
  blind: ['sees too little', 'Too few matches: the pose is dead reckoning by the IMU.'],
  rejected: ['much disagrees', 'Much of what is seen is not where it should be.'],
  jumps: ['jumps', 'The pose corrects itself again and again.'],
  accel_bias: ['accelerometer bias', 'Beyond what an accelerometer has.'],
  gyro_bias: ['gyro bias', 'Beyond what a gyro has.'],
  speed: ['too fast', 'Beyond what the device can do.'],
  stamps: ['stamps in doubt', 'The stamps of one sensor may be wrong.'],
  denied: ['lost not long ago', 'What ran before this start was hopeless.'],
  platform: ['on something that moves', 'The picture stands while the IMU is pushed.'],
  cameras: ['cameras disagree', 'They do not see at the same time, or are turned against each other.'],
  turn: ['axes in doubt', 'Gyro and image turn against each other: axes of the IMU, or T_BS?'],
  'dead reckoning': ['dead reckoning', 'By the IMU alone since the last image.'],
};

// In two words, and in a sentence. One that is not known is a newer server's.
export function reasonWords(reason) { return kReasons[reason] || [reason, '']; }
