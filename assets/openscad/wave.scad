linear_extrude(10) polygon(concat([for(x=[0:2:120]) [x,10+4*sin(x*9)]],[for(x=[120:-2:0]) [x,6+4*sin(x*9)]]));
