<Scenario>:
  <Road network>:
    <Road type>: T-intersection
    <No. lanes>: 3
    <Stem direction>: West
  <Actors>:
    <Vehicle_1>:
      <Model>: Sedan
      <Initial_position>: W2E
      <Actions>: Turn Left
      <Speed_limit>: 45
    <Vehicle_2>:
      <Model>: SUV
      <Initial_position>: N2S
      <Actions>: [[0, 0], [12.5, 3]]
      <Speed_limit>: Unknown
      <x-colour>: "red"
  <Env>:
    <Time>: Nighttime
    <Weather>: Clear
