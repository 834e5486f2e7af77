G01 F[100 * 5]
P1 = 2 ** 3 ** -1 - -4
P2 = SIN[30] + COS[P1] * ATAN2[1, -1] / PI
P[10 + 1] = ROUND[77.5] MOD 7
P3 = 'H1F' & '2#1011' | '8#17' ^ 12
P4 = [P1 > 2] OR [P2 <= 1.5e2] XOR NOT[0.49] AND FALSE
PP4 = MIN[MAX[1, 2], SQRT[ABS[-9]]]
P5 = EXIST[P1] + EXIST[M10] + INT[-1.5] + FRACT[1.25]
X[[P1 + P2] * [P3 - 1]] Y = P5 Z - P1
N[P5] X-P1
M30
